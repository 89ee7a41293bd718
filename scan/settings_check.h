// Settings that cannot change any of the files of a job.
#pragma once

#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Before the work: warns of each.
void warn_of_settings_without_effect(const ScanJob& job, ScanSession& session);

}  // namespace scanknit
