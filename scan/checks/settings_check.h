// Warns of settings that change none of a job's files.
#pragma once

#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// To be called before the work: warns of each such setting.
void warn_of_settings_without_effect(const ScanJob& job, ScanSession& session);

}  // namespace scanknit
