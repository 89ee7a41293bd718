// Manual pages.
#pragma once

#include <string>
#include <vector>

#include "app/cli/command_tree.h"

namespace scanknit {

struct ManPage {
  std::string file;  ///< "scanknit-run.1"
  std::string text;  ///< for troff, macros of man(7)
};

/// The program's page, then one for each command.
[[nodiscard]] std::vector<ManPage> man_pages(const CommandDescription& program);

}  // namespace scanknit
