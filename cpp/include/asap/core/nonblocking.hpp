// What must not block: no lock, no allocation, no sleep, no other system call. ASAP_NONBLOCKING
// marks such a function where the compiler knows the mark (clang from 20 on, -Wfunction-effects):
// it then proves the function and all that it calls. tests/realtime/run does so for the library.
// exempt() names what is not proved. Any thread, no cost.
#pragma once

#include <utility>

#if defined(__clang__) && defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
#define ASAP_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#ifndef ASAP_NONBLOCKING
#define ASAP_NONBLOCKING
#endif

namespace asap {

#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wunknown-warning-option"
#pragma clang diagnostic ignored "-Wfunction-effects"
#endif

// Calls what the compiler cannot prove. Each use stands beside its reason.
template <class Call>
decltype(auto) exempt(Call&& call) noexcept(noexcept(call())) ASAP_NONBLOCKING {
  return std::forward<Call>(call)();
}

#if defined(__clang__)
#pragma clang diagnostic pop
#endif

}  // namespace asap
