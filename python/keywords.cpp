#include "python/keywords.h"

namespace py = pybind11;

namespace scanknit {

void Keywords::refuse_others() const {
  for (const auto& [name, value] : given_) {
    throw py::type_error(fmt::format("unexpected keyword argument '{}'", name.cast<std::string>()));
  }
}

py::object Keywords::take(const char* name) {
  if (!given_.contains(name)) return py::none();
  return given_.attr("pop")(name);
}

}  // namespace scanknit
