#pragma once

// TOUCHABLE_SANITIZED: by AddressSanitizer or ThreadSanitizer. GCC says so by macros, Clang by features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TOUCHABLE_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TOUCHABLE_SANITIZED
#endif
#endif
#if defined(__SANITIZE_THREAD__)
#define TOUCHABLE_THREAD_SANITIZED
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define TOUCHABLE_THREAD_SANITIZED
#endif
#endif

/// Skips a test that cannot pass under ThreadSanitizer, for a reason of the test's own.
#ifdef TOUCHABLE_THREAD_SANITIZED
#define TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(reason) GTEST_SKIP() << (reason)
#else
#define TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(reason) static_assert(true)
#endif
