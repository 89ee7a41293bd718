// The one function of libscanknit_openni2.so.
#include "acquire/openni2/openni2_camera.h"
#include "acquire/openni2/openni2_plugin.h"
#include "core/version.h"

extern "C" __attribute__((visibility("default"))) const scanknit::OpenNi2Plugin* scanknit_openni2_plugin() {
  static constexpr scanknit::OpenNi2Plugin kPlugin{scanknit::kVersion, scanknit::list_openni2_cameras,
                                                   scanknit::open_openni2_camera};
  return &kPlugin;
}
