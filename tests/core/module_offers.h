// What the modules of test_module.cpp offer.
#pragma once

namespace scanknit::test {

struct ModuleOffers {
  int (*twice)(int number);
};

}  // namespace scanknit::test
