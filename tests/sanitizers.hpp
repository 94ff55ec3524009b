#pragma once

// TOUCHABLE_SANITIZED: by AddressSanitizer or ThreadSanitizer. GCC says so by macros, Clang by features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TOUCHABLE_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TOUCHABLE_SANITIZED
#endif
#endif
