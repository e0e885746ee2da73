/// @file  Counts the calls of malloc by this thread, those of Eigen included, which does not go through
/// operator new. Include in exactly one source file of a program: it replaces malloc (glibc). Under
/// AddressSanitizer, which brings its own, nothing is counted.
#pragma once

#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MOTIONLAB_COUNTS_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define MOTIONLAB_COUNTS_MALLOC 0
#endif
#endif
#ifndef MOTIONLAB_COUNTS_MALLOC
#define MOTIONLAB_COUNTS_MALLOC 1
#endif

namespace motionlab::test {
inline thread_local std::size_t malloc_calls = 0;
}

#if MOTIONLAB_COUNTS_MALLOC
extern "C" void* __libc_malloc(std::size_t size) noexcept;
extern "C" void* malloc(std::size_t size) noexcept {
  ++motionlab::test::malloc_calls;
  return __libc_malloc(size);
}
#endif
