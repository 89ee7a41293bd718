// The options of `align`.
#pragma once

#include <CLI/App.hpp>

#include "app/commands.h"

namespace scanknit {

void add_align_options(CLI::App& command, AlignArguments& align);

}  // namespace scanknit
