// The extension asap._core: a table of contents, no logic but how it begins. Each name is that of
// a file; algorithms bind themselves, see native_algorithm.hpp.
#include <pybind11/pybind11.h>

#include "asap/version.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "native_algorithm.hpp"

// clang-format off
namespace asap::python::gamma_filter { void bind(pybind11::module_& m); }
namespace asap::python::validator { void bind(pybind11::module_& m); }
namespace asap::python::schemes { void bind(pybind11::module_& m); }
namespace asap::python::telemetry { void bind(pybind11::module_& m); }
namespace asap::python::runner { void bind(pybind11::module_& m); }
namespace asap::python::pipeline { void bind(pybind11::module_& m); }
namespace asap::python::oracle { void bind(pybind11::module_& m); }
namespace asap::python::encoder { void bind(pybind11::module_& m); }
namespace asap::python::columns { void bind(pybind11::module_& m); }
namespace asap::python::decoders { void bind(pybind11::module_& m); }
namespace asap::python::synthetic { void bind(pybind11::module_& m); }
// clang-format on

namespace {

// Types stay registered, with NumPy too, whatever becomes of the import: what may take long, and so
// be interrupted, comes before them.
void begin_once() {
  static bool has_begun = false;
  pybind11::module_::import("numpy");
  asap::python::watch_exit_and_fork();
  if (has_begun) {
    throw pybind11::import_error(
        "asap: an import in this process did not come to its end; start Python anew");
  }
  has_begun = true;
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "Native core of asap.";
  m.attr("__version__") = std::string(asap::kVersion);

  begin_once();
  asap::python::gamma_filter::bind(m);
  asap::python::validator::bind(m);
  asap::python::schemes::bind(m);
  asap::python::telemetry::bind(m);
  asap::python::runner::bind(m);
  asap::python::pipeline::bind(m);
  asap::python::oracle::bind(m);
  asap::python::encoder::bind(m);
  asap::python::columns::bind(m);
  asap::python::decoders::bind(m);
  asap::python::synthetic::bind(m);
  asap::python::bind_algorithms(m);
  asap::python::close_classes(m);
}
