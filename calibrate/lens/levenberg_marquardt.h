// The damped descent that all estimates of this room share.
#pragma once

#include <utility>

namespace scanknit {

/// Levenberg-Marquardt (Levenberg 1944; Marquardt 1963). `cost_of(state)` falls from step to step;
/// `equations_of(state)` are its normal equations; `stepped(state, equations, damping)` solves them with diagonals
/// raised by a share of `damping`.
template <typename State, typename Cost, typename Equations, typename Step>
void descend(State& state, const Cost& cost_of, const Equations& equations_of, const Step& stepped) {
  constexpr int kMostSteps = 100;
  constexpr double kConverged = 1e-12;  // of the cost
  constexpr double kHighest = 1e12;
  double damping = 1e-3;
  double cost = cost_of(state);
  for (int step = 0; step < kMostSteps && damping < kHighest; ++step) {
    const auto equations = equations_of(state);
    bool is_better = false;
    double gained = 0;
    while (!is_better && damping < kHighest) {
      State next = stepped(state, equations, damping);
      const double next_cost = cost_of(next);
      is_better = next_cost <= cost;  // false for NaN
      damping *= is_better ? 0.1 : 10;
      if (!is_better) continue;
      gained = cost - next_cost;
      state = std::move(next);
      cost = next_cost;
    }
    if (gained <= kConverged * cost) return;
  }
}

}  // namespace scanknit
