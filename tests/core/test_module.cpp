// Modules are opened by name, and one that cannot be used is named with the reason and what to do.
#include <gtest/gtest.h>

#include <string>

#include "core/system/module.h"
#include "core/version.h"
#include "tests/core/module_offers.h"

namespace scanknit {
namespace {

void expect_refused(const std::string& name, const std::string& why) {
  const auto module = open_module(name, "Install it again");
  ASSERT_FALSE(module);
  EXPECT_EQ(module.error().code, ErrorCode::kInternal);
  EXPECT_EQ(module.error().text(),
            "the module libscanknit_" + name + ".so cannot be used: " + why + ". Install it again");
}

TEST(Module, OffersItsFunctions) {
  const auto module = load_module<test::ModuleOffers>("sound_module", "Install it again");
  ASSERT_TRUE(module) << module.error().text();
  EXPECT_EQ((*module)->twice(21), 42);
}

TEST(Module, IsTheSameWhenItIsOpenedAgain) {
  EXPECT_EQ(open_module("sound_module", "").value(), open_module("sound_module", "").value());
}

TEST(Module, OfAnotherVersionIsRefused) {
  std::string why = "it is of ScanKnit 0.0.1-old, not of ";
  expect_refused("old_module", why.append(kVersion));
}

TEST(Module, WithoutItsFunctionIsRefused) {
  expect_refused("no_module", "it is no module of ScanKnit");
}

TEST(Module, ThatIsMissingIsNamed) {
  expect_refused("that_is_not_there",
                 "libscanknit_that_is_not_there.so: cannot open shared object file: No such file or directory");
}

}  // namespace
}  // namespace scanknit
