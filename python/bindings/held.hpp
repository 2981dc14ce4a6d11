// How Python holds an object of ours. Class<T> binds T like py::class_, but every method takes its
// turn at the object: a thread waits, without the GIL, until the package of a runner or the call of
// another thread is finished. An object whose __init__ never ran has no holder, and pybind11
// refuses the call.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

namespace asap::python {

// A mutex that serves in the order of asking: with another one, a runner that is never idle would
// pass a reader for ever. Call lock() without the GIL.
class Turns {
 public:
  bool try_lock() noexcept;
  void lock() noexcept;
  void unlock() noexcept;
  bool are_mine() const noexcept { return owner_ == std::this_thread::get_id(); }

 private:
  std::atomic<std::uint32_t> next_{0};
  std::atomic<std::uint32_t> serving_{0};
  std::atomic<std::thread::id> owner_{};
};

// The turn of a caller from Python: taken with the GIL, which is released while it waits. Takes
// none at exit, where the other thread may never return, and none if this thread has the turn
// already.
class CallersTurn {
 public:
  explicit CallersTurn(Turns& turns);
  ~CallersTurn();
  CallersTurn(const CallersTurn&) = delete;
  CallersTurn& operator=(const CallersTurn&) = delete;

 private:
  Turns* turns_ = nullptr;
};

// An object of any class, its turns, and whether it has worked: whether its parameters no longer
// tell all of it. A native thread locks `turns` and touches no Python until it unlocks them.
struct Inside {
  Inside(void* given, void (*destroy)(void*)) : object(given, destroy) {}

  std::unique_ptr<void, void (*)(void*)> object;
  Turns turns;
  bool has_worked = false;
};

// A shared pointer to the inside of a T.
template <class T>
class Held {
 public:
  Held() = default;
  explicit Held(T* object)
      : inside_(
            std::make_shared<Inside>(object, [](void* gone) { delete static_cast<T*>(gone); })) {}

  T* get() const noexcept {
    return inside_ == nullptr ? nullptr : static_cast<T*>(inside_->object.get());
  }
  T& operator*() const noexcept { return *get(); }
  T* operator->() const noexcept { return get(); }
  Turns& turns() const noexcept { return inside_->turns; }
  bool& has_worked() const noexcept { return inside_->has_worked; }
  const std::shared_ptr<Inside>& inside() const noexcept { return inside_; }

 private:
  std::shared_ptr<Inside> inside_;
};

// The inside of an object of Python, which pybind11 refuses if its __init__ never ran.
using Open = std::shared_ptr<Inside> (*)(const pybind11::object&);
template <class T>
std::shared_ptr<Inside> inside_of(const pybind11::object& self) {
  return self.cast<Held<T>>().inside();
}

// The method as pybind11 binds it: on a holder, in its turn. One whose first argument is no T stays
// as it is.
template <class T, class Method, class R, class Self, class... Args>
auto in_turn(Method method, std::type_identity<R(Self, Args...)>) {
  if constexpr (std::is_base_of_v<std::remove_cvref_t<Self>, T>) {
    return [method](const Held<T>& self, Args... args) -> R {
      const CallersTurn turn(self.turns());
      if constexpr (!std::is_const_v<std::remove_reference_t<Self>>) self.has_worked() = true;
      return std::invoke(method, *self, std::forward<Args>(args)...);
    };
  } else {
    return method;
  }
}

template <class R, class... Args>
std::type_identity<R(Args...)> signature(R (*)(Args...));
template <class R, class F, class... Args>
std::type_identity<R(Args...)> signature(R (F::*)(Args...) const);

// A lambda that captures nothing is its function: all of one signature are bound by the same code.
template <class T, class Function>
  requires(!std::is_member_pointer_v<Function>)
auto in_turn(Function method) {
  if constexpr (requires { signature(+method); }) {
    return in_turn<T>(+method, decltype(signature(+method)){});
  } else {
    return in_turn<T>(std::move(method), decltype(signature(&Function::operator())){});
  }
}

template <class T, class R, class Owner, class... Args>
auto in_turn(R (Owner::*method)(Args...)) {
  return in_turn<T>(method, std::type_identity<R(T&, Args...)>{});
}

template <class T, class R, class Owner, class... Args>
auto in_turn(R (Owner::*method)(Args...) const) {
  return in_turn<T>(method, std::type_identity<R(const T&, Args...)>{});
}

// A method, or a property that is read, of a class of any type: `call` takes its `self` as an
// object.
template <class Call, class... Extra>
void def_method(const pybind11::object& type, const char* name, Call call, const Extra&... extra) {
  type.attr(name) = pybind11::cpp_function(
      std::move(call), pybind11::name(name), pybind11::is_method(type),
      pybind11::sibling(pybind11::getattr(type, name, pybind11::none())), extra...);
}
void def_property(const pybind11::object& type, const char* name, const pybind11::cpp_function& get,
                  const char* doc);

// Called when all classes of a module are bound. Prevents what would end the process: pickle of
// protocol 0 or 1, which calls the nameless base class of pybind11, and an object that is told that
// it is of another class of ours.
void close_classes(const pybind11::module_& m);

// A method that takes T&, and not const T&, is work.
template <class T, class... Bases>
class Class : public pybind11::class_<T, Bases..., Held<T>> {
  using Bound = pybind11::class_<T, Bases..., Held<T>>;

 public:
  using Bound::Bound;

  template <class First, class... Rest>
  Class& def(First&& first, Rest&&... rest) {
    if constexpr (std::is_convertible_v<First, const char*>) {
      method(first, rest...);
    } else {
      Bound::def(std::forward<First>(first), std::forward<Rest>(rest)...);
    }
    return *this;
  }

  template <class Read>
  Class& def_property_readonly(const char* name, Read read, const char* doc = "") {
    Bound::def_property_readonly(name, in_turn<T>(std::move(read)), doc);
    return *this;
  }

 private:
  template <class Work, class... Extra>
  void method(const char* name, Work work, const Extra&... extra) {
    Bound::def(name, in_turn<T>(std::move(work)), extra...);
  }
};

}  // namespace asap::python

PYBIND11_DECLARE_HOLDER_TYPE(T, asap::python::Held<T>)
