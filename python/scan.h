// scan(), capture(), align(), extract(): the program's commands that make a mesh.
#pragma once

#include <pybind11/pybind11.h>

namespace scanknit {

void add_scan(pybind11::module_& module);

}  // namespace scanknit
