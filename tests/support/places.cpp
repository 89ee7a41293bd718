#include "tests/support/places.h"

#include <cstdlib>

namespace scanknit::test {

const std::string kSourceDir = SCANKNIT_SOURCE_DIR;
const std::string kProgram = SCANKNIT_PROGRAM;
const std::string kNpmDir = SCANKNIT_NPM_DIR;
const std::string kHeadersFile = SCANKNIT_HEADERS_FILE;

std::filesystem::path data_folder() {
  const char* stated = std::getenv("SCANKNIT_TEST_DATA");
  return stated != nullptr ? stated : std::filesystem::path(kSourceDir) / ".." / "shared" / "data";
}

}  // namespace scanknit::test
