// The module libscanknit_openni2.so.
#include "acquire/openni2/openni2_camera.h"
#include "acquire/openni2/openni2_plugin.h"
#include "core/system/module.h"
#include "core/version.h"

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr OpenNi2Plugin kOffers{list_openni2_cameras, open_openni2_camera};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
