// What keeps a scanner from working, found without opening it, with the remedy in words.
#pragma once

#include <string>
#include <vector>

#include "acquire/device_source.h"
#include "core/result.h"

namespace scanknit {

struct Finding {
  enum class Grade {
    kGood,
    kNote,     ///< worth knowing; it works all the same
    kProblem,  ///< scanning will fail
  };
  Grade grade = Grade::kGood;
  std::string text;
  std::string remedy;  ///< empty: there is nothing to do
};

struct DeviceDiagnosis {
  DeviceInfo device;
  std::vector<Finding> findings;
};

struct Diagnosis {
  std::vector<Finding> system;
  std::vector<DeviceDiagnosis> devices;

  [[nodiscard]] bool has_problem() const;
};

/// Of every scanner that is plugged in, also of those that the system could not set up. Error (kDevice): USB cannot be
/// used at all.
[[nodiscard]] Result<Diagnosis> diagnose_devices();

}  // namespace scanknit
