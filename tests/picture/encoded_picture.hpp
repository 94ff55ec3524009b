#pragma once

#include <gtest/gtest.h>

#include <string>

#include "engine/picture/ffmpeg.hpp"

namespace touchable::test {

/// A picture of an FFmpeg format, encoded; `fill` sets its samples.
template <class Fill>
std::string encoded(const char* codec_name, AVPixelFormat format, int width, int height, Fill&& fill) {
    const AVCodec* codec = avcodec_find_encoder_by_name(codec_name);
    const CodecPtr encoder(avcodec_alloc_context3(codec));
    const FramePtr frame(av_frame_alloc());
    const PacketPtr packet(av_packet_alloc());
    encoder->width = frame->width = width;
    encoder->height = frame->height = height;
    encoder->pix_fmt = format;
    frame->format = format;
    encoder->time_base = {1, 1};
    encoder->flags |= AV_CODEC_FLAG_QSCALE;
    frame->quality = encoder->global_quality = 2 * FF_QP2LAMBDA;
    EXPECT_GE(avcodec_open2(encoder.get(), codec, nullptr), 0);
    EXPECT_GE(av_frame_get_buffer(frame.get(), 0), 0);
    fill(*frame);
    EXPECT_GE(avcodec_send_frame(encoder.get(), frame.get()), 0);
    EXPECT_GE(avcodec_send_frame(encoder.get(), nullptr), 0);
    EXPECT_GE(avcodec_receive_packet(encoder.get(), packet.get()), 0);
    return {reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size)};
}

}  // namespace touchable::test
