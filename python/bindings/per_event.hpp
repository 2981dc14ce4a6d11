// What every event-by-event algorithm has in Python besides its constructor.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "arrays.hpp"
#include "asap/runner/tiled.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "keywords.hpp"
#include "native_algorithm.hpp"

namespace asap::python {

namespace py = pybind11;

// The docstring whose words in $ stand for what all of them say alike.
std::string documented(const std::string& text);

// The docstring of process(events), and of one that has `labels`; `returns` tells what comes back.
std::string process_doc(const char* returns, bool has_labels = false);

// process(events) of any kind.
template <class T, class Process>
void bind_process(Class<T>& type, Process process, const char* returns) {
  type.def("process", process, py::arg("events").noconvert(), process_doc(returns).c_str());
}

// process() that returns None.
void def_taking(const py::object& type, const NativeAlgorithm& calls);
template <class Algorithm>
void bind_taking(Class<Algorithm>& type) {
  def_taking(type, native_calls<Algorithm>());
}

// process() of a filter.
void def_passing(const py::object& type, const NativeAlgorithm& calls);
template <class Algorithm>
void bind_passing(Class<Algorithm>& type) {
  def_passing(type, native_calls<Algorithm>());
}

// process() of a tracker that gives every event an id.
using Label = void (*)(void*, EventSpan, std::span<std::int32_t>);
void def_labelled(const py::object& type, const NativeAlgorithm& calls, Label label,
                  const char* returns);
template <class Tracker>
void bind_labelled(Class<Tracker>& type, const char* returns) {
  const Label label = [](void* self, EventSpan events, std::span<std::int32_t> ids) {
    static_cast<Tracker*>(self)->process(events, ids);
  };
  def_labelled(type, native_calls<Tracker>(), label, returns);
}

// process() of an algorithm that gives every event a Value, in NumPy `columns` of a dtype.
using Answer = void (*)(void*, EventSpan, void*);
void def_answering(const py::object& type, Open open, Answer answer, const py::dtype& dtype,
                   std::size_t columns, const char* returns);
template <class Element, class Value, class Algorithm>
void bind_answering(Class<Algorithm>& type, const char* returns) {
  const Answer answer = [](void* self, EventSpan events, void* out) {
    static_cast<Algorithm*>(self)->process(events, {static_cast<Value*>(out), events.size()});
  };
  def_answering(type, &inside_of<Algorithm>, answer, py::dtype::of<Element>(),
                sizeof(Value) / sizeof(Element), returns);
}

// All but process(). `gamma` tells what set_gamma changes; null: its set_gamma is the caller's.
void def_rest(const py::object& type, const char* name, const NativeAlgorithm& calls,
              const char* gamma);

// The values of a surface, shape (height, width).
template <class Value, class Surface>
py::array_t<Value> copied(const Surface& surface) {
  py::array_t<Value> copy({surface.config().height, surface.config().width});
  surface.copy_to(std::span(copy.mutable_data(), static_cast<std::size_t>(copy.size())));
  return copy;
}

// ---- asap.Tiled: each algorithm that can be tiled has a class for it, `_Tiled` ----

template <class A>
struct TiledArguments : A::Config {
  int threads = 0;  // which the constructor refuses
};

template <class A>
class TiledAlgorithm : public Tiled<A> {
 public:
  using Config = TiledArguments<A>;

  explicit TiledAlgorithm(const Config& config)
      : Tiled<A>(config, {.threads = config.threads}), config_(config) {}

  const Config& config() const noexcept { return config_; }

 private:
  Config config_;
};

template <class A>
void bind_tiled(Class<A>& type, const char* name, const Table& keywords, const char* gamma) {
  using T = TiledAlgorithm<A>;
  constexpr const char* kReturns = "What the algorithm's own process(events) returns.";
  Class<T> tiled(type, "_Tiled", "See asap.Tiled.");
  tiled.attr("__name__") = "Tiled";
  tiled.attr("_of") = py::cast<std::string>(type.attr("__name__")) + ", ";  // for its repr
  if constexpr (Filter<T>) {
    bind_passing(tiled);
  } else if constexpr (requires { typename A::Value; }) {
    bind_taking(tiled);
    tiled.def_property_readonly("surface", &copied<typename A::Value, T>);
  } else if constexpr (std::is_same_v<typename T::Answer, std::uint8_t>) {
    bind_answering<bool, std::uint8_t>(tiled, kReturns);
  } else {
    bind_answering<float, typename T::Answer>(tiled, kReturns);
  }
  Keywords<TiledArguments<A>> all(keywords.by_position, {});
  all.rows = keywords.rows;
  all.rows.push_back(keyword("threads", &TiledArguments<A>::threads));
  bind_configuration(tiled, all);
  def_rest(tiled, name, native_calls<T>(), gamma);
}

template <class Algorithm>
void bind_rest(Class<Algorithm>& type, const char* name,
               const Keywords<typename Algorithm::Config>& keywords, const char* gamma) {
  bind_configuration(type, keywords);
  def_rest(type, name, native_calls<Algorithm>(), gamma);
  if constexpr (Tileable<Algorithm>) bind_tiled(type, name, keywords, gamma);
}

}  // namespace asap::python
