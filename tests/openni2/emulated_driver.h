// What tests know of the emulated driver. It is loaded by the OpenNI2 library; its functions are found by name.
#pragma once

namespace scanknit::test {

inline constexpr const char* kEmulatedUri = "emulated/0";

// extern "C" void scanknit_emulated_plug(), scanknit_emulated_unplug(): as if the device came or went.
// scanknit_emulated_fall_silent(): no pictures until its streams are started again. scanknit_emulated_stay_silent():
// none until it is opened again. scanknit_emulated_lose_colour(): no colour until it is opened again; depth goes on.

}  // namespace scanknit::test
