// What must not block: no lock, no allocation, no sleep, no system call; any thread. clang from 20
// on (-Wfunction-effects) proves a marked function with all that it calls; tests/realtime/run does
// so for the library. exempt() names what is not proved; RealtimeSanitizer does not look there.
//   void step(EventSpan events) noexcept ASAP_NONBLOCKING;
#pragma once

#include <utility>

#if defined(__clang__) && __clang_major__ >= 20  // 19 wants the mark at each definition, too
#if __has_cpp_attribute(clang::nonblocking)
#define ASAP_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#include <sanitizer/rtsan_interface.h>
#define ASAP_UNWATCHED [[maybe_unused]] const __rtsan::ScopedDisabler unwatched
#endif
#endif
#ifndef ASAP_UNWATCHED
#define ASAP_UNWATCHED static_cast<void>(0)
#endif
#ifndef ASAP_NONBLOCKING
#define ASAP_NONBLOCKING
#endif

namespace asap::inline v0_1 {

#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wunknown-warning-option"
#pragma clang diagnostic ignored "-Wfunction-effects"
#endif

// Calls what the compiler cannot prove. Each use stands beside its reason.
template <class Call>
decltype(auto) exempt(Call&& call) noexcept(noexcept(call())) ASAP_NONBLOCKING {
  ASAP_UNWATCHED;
  return std::forward<Call>(call)();
}

#if defined(__clang__)
#pragma clang diagnostic pop
#endif
#undef ASAP_UNWATCHED

}  // namespace asap::inline v0_1
