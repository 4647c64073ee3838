// SPDX-License-Identifier: Apache-2.0
#include "errors.h"

#include <pybind11/pybind11.h>

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "console.h"
#include "ovoid/error.h"
#include "usage.h"
#include "values.h"

namespace ovoid::python {
namespace {

namespace py = pybind11;

void raise(ErrorCode code, const std::string& words) {
  const py::object error = py::module_::import("ovoid._errors")
                               .attr("error_of")(name_of(code), cli::message_line(words));
  PyErr_SetObject(py::type::of(error).ptr(), error.ptr());
}

}  // namespace

void translate_errors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      raise(error.code(), error.what());
    } catch (const cli::UsageError& error) {
      raise(ErrorCode::kInvalidArgument, error.what());
    } catch (const cli::BadValue& error) {
      raise(ErrorCode::kInvalidArgument, error.what());
    } catch (const std::bad_alloc&) {
      raise(ErrorCode::kOutOfMemory, "out of memory");
    } catch (const std::length_error&) {  // more than an address space holds
      raise(ErrorCode::kOutOfMemory, "out of memory");
    }
  });
}

}  // namespace ovoid::python
