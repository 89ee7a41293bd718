#include "scan/passes.h"

#include <utility>

#include "scan/refine/loop_refiner.h"
#include "scan/refine/turntable_refiner.h"

namespace scanknit {
namespace {

PassResult run_pass(const ScanJob& job, const PassInput& input, PoseRefiner& refiner, ScanSession& session) {
  ScanPass pass(job, input, refiner, session);
  PassResult made;
  Result<void> outcome = pass.run();
  made.scan = pass.result();
  made.scan.outcome = std::move(outcome);
  made.taken = pass.intake().taken();
  made.left_out = pass.intake().left_out();
  made.crop = pass.crop();
  made.has_given_up = pass.has_given_up();
  made.misfit = pass.misfit();
  made.fused = pass.fused_order();
  made.samples = pass.sample_sequences();
  return made;
}

}  // namespace

PassResult scan_walk(const ScanJob& job, const PassInput& input, ScanSession& session) {
  const auto refiner = loop_refiner(job.config, input.source.info().poses, input.archive, session);
  return run_pass(job, input, *refiner, session);
}

PassResult scan_turntable(const ScanJob& job, const PassInput& input, ScanSession& session) {
  TurntableRefiner refiner(job, input.source.info().poses, input.archive, session);
  return run_pass(job, input, refiner, session);
}

ScanResult replacing(ScanResult first, ScanResult second) {
  if (second.input.empty()) second.input = std::move(first.input);
  if (!second.losses) second.losses = first.losses;
  if (!second.turntable) second.turntable = std::move(first.turntable);
  second.files.merge(first.files);
  return second;
}

}  // namespace scanknit
