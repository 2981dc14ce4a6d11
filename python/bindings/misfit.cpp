#include "misfit.hpp"

#include <pybind11/numpy.h>

#include <algorithm>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"

namespace asap::python {
namespace {

namespace py = pybind11;

constexpr std::string_view kNumber = "typing.SupportsFloat | typing.SupportsIndex";
constexpr std::string_view kSequence = "collections.abc.Sequence[";
constexpr std::string_view kOurs = "asap._core.";

struct Parameter {
  std::string_view name;
  std::string_view type;
  bool required = true;
  bool by_name_only = false;
};

struct Given {
  const Parameter* parameter;
  py::handle value;
};

enum class Fit { kYes, kWrongKind, kOutOfRange };

// The parts of a text between separators that stand outside of brackets and quotes.
std::vector<std::string_view> split(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> parts;
  std::size_t begin = 0;
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\'') quoted = !quoted;
    if (std::string_view("([").find(text[i]) != std::string_view::npos) ++depth;
    if (std::string_view(")]").find(text[i]) != std::string_view::npos) --depth;
    if (quoted || depth > 0 || !text.substr(i).starts_with(separator)) continue;
    parts.push_back(text.substr(begin, i - begin));
    begin = i + separator.size();
  }
  parts.push_back(text.substr(begin));
  return parts;
}

// Of "(self: A, x: B = 1, *, y: C, **kwargs) -> D": self, x and y, whose name says it.
std::vector<Parameter> parameters_of(std::string_view signature) {
  std::vector<Parameter> parameters;
  bool by_name_only = false;
  for (std::string_view text : split(signature.substr(1, signature.rfind(") -> ") - 1), ", ")) {
    by_name_only = by_name_only || text.starts_with("*");
    const std::size_t colon = text.find(": ");
    if (colon == std::string_view::npos) continue;
    const auto halves = split(text.substr(colon + 2), " = ");
    parameters.push_back({text.substr(0, colon), halves[0], halves.size() == 1, by_name_only});
  }
  return parameters;
}

// What an attempt to convert has said; what is the argument's own error comes out.
Fit verdict(const py::object& converted) {
  if (converted) return Fit::kYes;
  const bool too_large = PyErr_ExceptionMatches(PyExc_OverflowError) != 0;
  if (!too_large && PyErr_ExceptionMatches(PyExc_TypeError) == 0 &&
      PyErr_ExceptionMatches(PyExc_ValueError) == 0) {
    throw py::error_already_set();
  }
  PyErr_Clear();
  return too_large ? Fit::kOutOfRange : Fit::kWrongKind;
}

Fit fit_number(py::handle value) {
  if (PyNumber_Check(value.ptr()) == 0) return Fit::kWrongKind;
  return verdict(py::reinterpret_steal<py::object>(PyNumber_Float(value.ptr())));
}

Fit fit_whole_number(py::handle value) {
  return verdict(py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr())));
}

Fit fit_text(py::handle value) {  // a lone surrogate has no UTF-8
  return verdict(py::reinterpret_steal<py::object>(PyUnicode_AsUTF8String(value.ptr())));
}

Fit when(bool fits) { return fits ? Fit::kYes : Fit::kWrongKind; }

Fit fit_truth(py::handle value) {
  const PyNumberMethods* methods = Py_TYPE(value.ptr())->tp_as_number;
  if (!value.is_none() && (methods == nullptr || methods->nb_bool == nullptr)) {
    return Fit::kWrongKind;
  }
  return verdict(PyObject_IsTrue(value.ptr()) < 0 ? py::object() : py::none());
}

Fit fit(std::string_view type, py::handle value);

// Element by element; `types` are those of a tuple, or the one of all.
Fit fit_elements(const std::vector<std::string_view>& types, bool is_tuple, py::handle value) {
  const bool text = py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value);
  if (text || PySequence_Check(value.ptr()) == 0) return Fit::kWrongKind;
  const auto all =
      py::reinterpret_steal<py::object>(PySequence_Fast(value.ptr(), "expected a sequence"));
  if (!all) return verdict(all);
  const std::size_t count = py::len(all);
  if (is_tuple && count != types.size()) return Fit::kWrongKind;
  for (std::size_t i = 0; i < count; ++i) {
    const Fit element = fit(types[is_tuple ? i : 0], all[py::int_(i)]);
    if (element != Fit::kYes) return element;
  }
  return Fit::kYes;
}

Fit fit(std::string_view type, py::handle value) {
  if (type == "object") return Fit::kYes;
  if (value.is_none() && type.ends_with("| None")) return Fit::kYes;
  if (type.starts_with(kNumber)) return fit_number(value);
  if (type.starts_with(kWholeNumber)) return fit_whole_number(value);
  if (type.starts_with("bool")) return fit_truth(value);
  if (type.starts_with("str")) return fit_text(value);
  if (type.starts_with("bytes")) return when(py::isinstance<py::bytes>(value));
  if (type.starts_with("numpy.ndarray")) return when(py::isinstance<py::array>(value));
  if (type.starts_with(kOurs)) {
    const std::string name(split(type.substr(kOurs.size()), " | ")[0]);
    return when(py::isinstance(value, py::module_::import("asap._core").attr(name.c_str())));
  }
  const bool is_tuple = type.starts_with("tuple[");
  if (!is_tuple && !type.starts_with(kSequence)) return Fit::kYes;  // not known here
  const std::size_t begin = type.find('[') + 1;
  return fit_elements(split(type.substr(begin, type.rfind(']') - begin), ", "), is_tuple, value);
}

void replace(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
}

std::string remedy(const Parameter& parameter) {
  if (parameter.name == "events") {
    return kGiveEvents;
  }
  std::string type(parameter.type);
  replace(type, kNumber, "number");
  replace(type, kWholeNumber, "whole number");
  replace(type, "collections.abc.", "");
  replace(type, "numpy.ndarray", "array");
  replace(type, kOurs, "asap.");
  replace(type, " | ", " or ");
  if (type.starts_with("bool")) return "give True or False";
  if (type.starts_with("str")) return "give text";
  const bool vowel = std::string_view("ai").find(type[0]) != std::string_view::npos;
  return (vowel ? "give an " : "give a ") + type;
}

std::string named(std::string_view name, py::handle value) {
  return std::string(name) + " = " + shown(value) + ": ";
}

std::string names_of(const std::vector<Parameter>& parameters) {
  std::string names;
  for (const Parameter& parameter : parameters) {
    if (parameter.name == "self") continue;
    names.append(names.empty() ? "" : ", ").append(parameter.name);
  }
  return names.empty() ? "it takes none" : "it takes " + names;
}

// A whole number that is one and yet did not fit: the largest of those that 32 bits do not hold,
// for the text does not tell how many bits there are.
std::optional<Misfit> out_of_range(const std::vector<Given>& all) {
  const Given* largest = nullptr;
  bool negative = false;
  py::object most = py::int_(0);
  const py::int_ most_of_32_bits(0x7fffffff);
  for (const Given& given : all) {
    if (!given.parameter->type.starts_with(kWholeNumber) || given.value.is_none()) continue;
    const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(given.value.ptr()));
    const auto size = py::reinterpret_steal<py::object>(PyNumber_Absolute(number.ptr()));
    if (!(size > most) || (number > py::int_(0) && number <= most_of_32_bits)) continue;
    most = size;
    largest = &given;
    negative = number < py::int_(0);
  }
  if (largest == nullptr) return std::nullopt;
  return Misfit{PyExc_ValueError, named(largest->parameter->name, largest->value) +
                                      (negative ? "too small" : "too large")};
}

// Of Deadline, which had it until the law chose the length of a package itself.
constexpr const char* kKneeIsGone =
    "gone: the law chooses the length of a package itself, and prefer what it gains; ";

}  // namespace

std::optional<Misfit> find_misfit(std::string_view signature, const Call& call) {
  const std::vector<Parameter> parameters = parameters_of(signature);
  const auto by_name_only = std::ranges::find(parameters, true, &Parameter::by_name_only);
  const auto by_position = static_cast<std::size_t>(by_name_only - parameters.begin());
  if (call.count > by_position) {
    return Misfit{PyExc_TypeError, shown(call.values[by_position]) +
                                       ": too many values without a name; " + names_of(parameters)};
  }
  std::vector<Given> all;
  for (std::size_t i = 0; i < call.count; ++i) all.push_back({&parameters[i], call.values[i]});
  const std::size_t names = call.names ? py::len(call.names) : 0;
  for (std::size_t i = 0; i < names; ++i) {
    const auto name = py::cast<std::string>(call.names[py::int_(i)]);
    const py::handle value = call.values[call.count + i];
    const auto known = std::ranges::find(parameters, name, &Parameter::name);
    if (known != parameters.end()) {
      if (std::ranges::find(all, &*known, &Given::parameter) != all.end()) {
        return Misfit{PyExc_TypeError, named(name, value) + "given by position already"};
      }
      all.push_back({&*known, value});
    } else if (signature.find("**") == std::string_view::npos) {
      const bool is_gone = name == "knee" && signature.find("prefer:") != std::string_view::npos;
      return Misfit{PyExc_TypeError, named(name, value) +
                                         (is_gone ? kKneeIsGone : "no such argument; ") +
                                         names_of(parameters)};
    }
  }
  for (const Parameter& parameter : parameters) {
    if (parameter.required && std::ranges::find(all, &parameter, &Given::parameter) == all.end()) {
      return Misfit{PyExc_TypeError,
                    std::string(parameter.name) + " is missing: " + remedy(parameter)};
    }
  }
  for (const Given& given : all) {
    const Fit found = fit(given.parameter->type, given.value);
    if (found == Fit::kYes) continue;
    const bool range = found == Fit::kOutOfRange;
    return Misfit{range ? PyExc_ValueError : PyExc_TypeError,
                  named(given.parameter->name, given.value) +
                      (range ? "out of range" : remedy(*given.parameter))};
  }
  return out_of_range(all);
}

}  // namespace asap::python
