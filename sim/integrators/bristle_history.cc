#include "sim/integrators/bristle_history.h"

#include <algorithm>

#include "sim/math/check.h"

namespace knap {

namespace {

// Where each bristle of a list stands in another one, asked for by ascending number; −1 where it does not.
class Lookup {
 public:
  explicit Lookup(const std::vector<int>& id) : id_(id) {}
  int Find(int id) {
    while (next_ < id_.size() && id_[next_] < id) ++next_;
    return next_ < id_.size() && id_[next_] == id ? static_cast<int>(next_) : -1;
  }

 private:
  const std::vector<int>& id_;
  std::size_t next_ = 0;
};

void MergeInto(const std::vector<int>& more, std::vector<int>* ids) {
  ids->insert(ids->end(), more.begin(), more.end());
  std::sort(ids->begin(), ids->end());
  ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
}

}  // namespace

void CalcBristleBase(const StepFormula& f, const BristleState& now, const BristleState& before, const Bristles* also,
                     Bristles* base) {
  base->id.assign(now.bent.id.begin(), now.bent.id.end());
  if (f.zeta != 0.0) MergeInto(before.bent.id, &base->id);
  if (also != nullptr) MergeInto(also->id, &base->id);
  base->z.resize(base->id.size());
  Lookup in_now(now.bent.id);
  Lookup in_before(before.bent.id);
  for (std::size_t i = 0; i < base->id.size(); ++i) {
    Bristle& z = base->z[i];
    z.setZero();
    const int n = in_now.Find(base->id[i]);
    if (n >= 0) {
      z += (1.0 + f.zeta) * now.bent.z[n];
      if (f.e != 0.0) z += f.e * now.rate[n];
    }
    const int b = f.zeta != 0.0 ? in_before.Find(base->id[i]) : -1;
    if (b >= 0) z -= f.zeta * before.bent.z[b];
  }
}

void CalcBristleRates(const StepFormula& f, const Bristles& base, BristleState* next) {
  const double rate = f.h_contact > 0.0 ? 1.0 / f.h_contact : 0.0;
  next->rate.resize(next->bent.z.size());
  Lookup in_base(base.id);
  for (int i = 0; i < next->bent.size(); ++i) {
    next->rate[i] = rate * next->bent.z[i];
    const int b = in_base.Find(next->bent.id[i]);
    if (b >= 0) next->rate[i] -= rate * base.z[b];
  }
}

void PullBackBristleRates(const StepFormula& f, const Bristles& base, const BristleState& next, BristleCotangents* bar,
                          std::vector<Bristle>* bar_base) {
  Lookup in_base(base.id);
  for (int i = 0; i < next.bent.size(); ++i) {
    const Bristle by_difference = bar->rate[i] / f.h_contact;
    bar->bent[i] += by_difference;
    const int b = in_base.Find(next.bent.id[i]);
    KNAP_CHECK(b >= 0, "bristle {} is not listed in its base", next.bent.id[i]);
    (*bar_base)[b] -= by_difference;
  }
}

void PullBackBristleBase(const StepFormula& f, const Bristles& base, const std::vector<Bristle>& bar_base,
                         const BristleState& now, const BristleState& before, BristleCotangents* bar_now,
                         BristleCotangents* bar_before) {
  Lookup in_now(now.bent.id);
  Lookup in_before(before.bent.id);
  for (std::size_t i = 0; i < base.id.size(); ++i) {
    const int n = in_now.Find(base.id[i]);
    if (n >= 0) {
      bar_now->bent[n] += (1.0 + f.zeta) * bar_base[i];
      bar_now->rate[n] += f.e * bar_base[i];
    }
    const int b = f.zeta != 0.0 ? in_before.Find(base.id[i]) : -1;
    if (b >= 0) bar_before->bent[b] -= f.zeta * bar_base[i];
  }
}

}  // namespace knap
