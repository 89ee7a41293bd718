// scanknit.scan(): the whole scan, from a recording to files.
#pragma once

#include <pybind11/pybind11.h>

namespace scanknit {

void add_scan(pybind11::module_& module);

}  // namespace scanknit
