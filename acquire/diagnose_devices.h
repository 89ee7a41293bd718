// Finds out why a scanner does not work, without opening it, and describes the remedy.
#pragma once

#include <string>
#include <vector>

#include "acquire/device_source.h"
#include "core/result.h"

namespace scanknit {

struct Finding {
  enum class Grade {
    kGood,
    kNote,     ///< information; the scanner works
    kProblem,  ///< scanning will fail
  };
  Grade grade = Grade::kGood;
  std::string text;
  std::string remedy;  ///< empty: none is needed
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

/// Diagnoses every scanner that is plugged in, also those that the system could not set up. Error (kDevice): USB cannot
/// be used at all.
[[nodiscard]] Result<Diagnosis> diagnose_devices();

}  // namespace scanknit
