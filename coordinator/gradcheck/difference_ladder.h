// Central differences of one parameter over a ladder of steps, judged against an analytic derivative.
//
// All in range-normalised parameters: x = (theta − lower)/(upper − lower), so that a step of 1e-3 is a thousandth of
// the range. A large step errs by truncation, h²·L'''/6, a small one by the loss's own rounding over h; in between lies
// a plateau where neither shows. The derivative is confirmed by a window of kWindow consecutive steps that all agree
// with it: one step alone could agree by chance. From step to step truncation falls to a quarter and rounding doubles,
// so three that agree within the same bound are neither. Where truncation and rounding leave no room for three steps
// between them, the same is asked of differences of fourth order, (4 D(h/2) − D(h))/3, whose truncation falls to a
// sixteenth [Richardson 1911].
#pragma once

#include <array>
#include <vector>

namespace knap {

// Steps 2^(−10), 2^(−11), … 2^(−30) (1e-3 to 1e-9), as fractions of the range.
inline constexpr int kLadderSteps = 21;
inline constexpr int kWindow = 3;
double CalcLadderStep(int k);  // 0 ≤ k < kLadderSteps
double CalcLargestStep();      // CalcLadderStep(0)

class DifferenceLadder {
 public:
  // Steps to evaluate next: first the window in the middle, then one more at each end; empty at the ladder's ends.
  std::vector<int> ListNextSteps() const;

  // The difference quotient at step k, one of ListNextSteps(); NaN where it could not be had.
  void Set(int k, double difference);

  // The window whose worst |difference − derivative| is least.
  struct Window {
    int middle = 0;           // its step in the middle
    double error = 0.0;       // largest |difference − derivative| of its steps; infinity with a NaN among them
    double difference = 0.0;  // at the middle
    int plateau_steps = 0;    // consecutive steps, this window among them, with an error of at most `tolerance`
  };
  // Needs the first window's steps. Of fourth order where the differences themselves have no plateau and those do.
  Window FindBestWindow(double derivative, double tolerance) const;

 private:
  template <class Difference>
  static Window FindBest(const Difference& difference, int first, int last, double derivative, double tolerance);

  std::array<double, kLadderSteps> differences_{};
  int first_ = 0, last_ = -1;  // evaluated: first_ … last_
};

}  // namespace knap
