// Where tests find things. Only places.cpp knows the paths of this checkout: all other objects of the tests are the
// same in every checkout, so that the compiler cache serves them.
#pragma once

#include <filesystem>
#include <string>

namespace scanknit::test {

extern const std::string kSourceDir;    ///< the checkout
extern const std::string kProgram;      ///< scanknit as it was built
extern const std::string kNpmDir;       ///< where `npm ci` puts the packages of tests/package.json
extern const std::string kHeadersFile;  ///< names the headers that are installed, a line each

/// Recordings and reference sets that are not part of the project: $SCANKNIT_TEST_DATA, or ../shared/data beside the
/// checkout. May be missing.
[[nodiscard]] std::filesystem::path data_folder();

}  // namespace scanknit::test
