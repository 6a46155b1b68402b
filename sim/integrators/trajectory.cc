#include "sim/integrators/trajectory.h"

#include <algorithm>
#include <utility>

#include "sim/math/check.h"

namespace knap {

using Eigen::VectorXd;

namespace {

constexpr int kLeastPresent = 3;  // blocks: a step looks at two, and one more may be on its way

}  // namespace

void Trajectory::Reserve(int states) {
  times_.reserve(states);
  formulas_.reserve(states);
  state_of_step_.reserve(states);
  Block& block = blocks_.back();
  const auto rows = static_cast<std::size_t>(std::min(states, kStepsPerBlock + 2));
  block.q.reserve(rows * nq_);
  for (std::vector<double>* numbers : {&block.v, &block.xi, &block.vdot}) numbers->reserve(rows * nv_);
  block.bristle_start.reserve(rows + 1);
}

void Trajectory::Append(double time, const StepFormula& formula, const VectorXd& q, const VectorXd& v,
                        const VectorXd& xi, const VectorXd& vdot, const BristleState& bristles) {
  times_.push_back(time);
  formulas_.push_back(formula);
  Block& block = blocks_.back();
  block.end = size();
  block.q.insert(block.q.end(), q.data(), q.data() + nq_);
  block.v.insert(block.v.end(), v.data(), v.data() + nv_);
  block.xi.insert(block.xi.end(), xi.data(), xi.data() + nv_);
  block.vdot.insert(block.vdot.end(), vdot.data(), vdot.data() + nv_);
  Bristles& bent = block.bristles.bent;
  bent.id.insert(bent.id.end(), bristles.bent.id.begin(), bristles.bent.id.end());
  bent.z.insert(bent.z.end(), bristles.bent.z.begin(), bristles.bent.z.end());
  block.bristles.rate.insert(block.bristles.rate.end(), bristles.rate.begin(), bristles.rate.end());
  block.bristle_start.push_back(bent.size());
}

void Trajectory::CutBackTo(int size) {
  times_.resize(size);
  formulas_.resize(size);
  Block& block = blocks_.back();
  block.end = size;
  const int rows = size - block.first;
  block.q.resize(static_cast<std::size_t>(rows) * nq_);
  for (std::vector<double>* numbers : {&block.v, &block.xi, &block.vdot}) {
    numbers->resize(static_cast<std::size_t>(rows) * nv_);
  }
  block.bristle_start.resize(rows + 1);
  block.bristles.bent.id.resize(block.bristle_start.back());
  block.bristles.bent.z.resize(block.bristle_start.back());
  block.bristles.rate.resize(block.bristle_start.back());
}

TimeNodeList Trajectory::ListNodes() const {
  TimeNodeList nodes;
  nodes.ends.resize(whole_steps());
  for (int n = 0; n < whole_steps(); ++n) {
    for (int k = state_of_step(n) + 1; k <= state_of_step(n + 1); ++k) {
      if (!formula(k).is_stage) nodes.ends[n].push_back({.time = time(k)});
    }
  }
  return nodes;
}

Trajectory::Seed Trajectory::MakeSeed() const {
  const int k = size() - 1;
  Seed seed{time(k), formula(k), q(k), v(k), xi(k), vdot(k), VectorXd(), {}, choice_};
  if (k > 0) seed.v_before = v(k - 1);
  GetBristles(k, &seed.bristles);
  return seed;
}

void Trajectory::BeginBlock() {
  Block block;
  block.first = block.end = size();
  block.seed = MakeSeed();
  block.used = ++clock_;
  blocks_.push_back(std::move(block));
  recent_ = blocks_.size() - 1;
  Reserve(static_cast<int>(times_.capacity()));
}

std::size_t Trajectory::CountBytes() const {
  std::size_t numbers = 0;
  std::size_t bristles = 0;
  for (const Block& block : blocks_) {
    numbers += block.q.capacity() + block.v.capacity() + block.xi.capacity() + block.vdot.capacity();
    bristles += block.bristles.rate.capacity();
  }
  return numbers * sizeof(double) + bristles * (2 * sizeof(Bristle) + sizeof(int));
}

bool Trajectory::OutgrowsMemory() const { return CountBytes() > memory_; }

void Trajectory::DropBlocks() const {
  while (OutgrowsMemory()) {
    Block* oldest = nullptr;
    int present = 0;
    for (Block& block : blocks_) {
      if (!block.present) continue;
      ++present;
      if (oldest == nullptr || block.used < oldest->used) oldest = &block;
    }
    if (present <= kLeastPresent) return;
    for (std::vector<double>* numbers : {&oldest->q, &oldest->v, &oldest->xi, &oldest->vdot}) {
      std::vector<double>().swap(*numbers);
    }
    oldest->bristles = {};
    oldest->bristle_start = {0};
    oldest->present = false;
  }
}

const Trajectory::Block& Trajectory::GetBlock(int k) const {
  const Block& recent = blocks_[recent_];
  if (recent.first <= k && k < recent.end && recent.present) return recent;
  auto block = std::upper_bound(blocks_.begin(), blocks_.end(), k, [](int i, const Block& b) { return i < b.first; });
  --block;
  recent_ = static_cast<std::size_t>(block - blocks_.begin());
  block->used = ++clock_;
  if (!block->present) {
    Restore(&*block);
    DropBlocks();
  }
  return *block;
}

void Trajectory::Restore(Block* block) const {
  ++replays_;
  const int index = static_cast<int>(block - blocks_.data());
  Trajectory again = replay_(block->seed, index * kStepsPerBlock, controls);
  // The seed's states lead the record; the first block has only its own.
  const int skip = index == 0 ? 0 : 2;
  Block& record = again.blocks_.front();
  KNAP_CHECK(again.size() - skip == block->end - block->first, "a block of {} states came out as {}",
             block->end - block->first, again.size() - skip);
  if (skip > 0) {
    record.q.erase(record.q.begin(), record.q.begin() + skip * nq_);
    for (std::vector<double>* numbers : {&record.v, &record.xi, &record.vdot}) {
      numbers->erase(numbers->begin(), numbers->begin() + skip * nv_);
    }
    const int seeded = record.bristle_start[skip];
    BristleState& bristles = record.bristles;
    bristles.bent.id.erase(bristles.bent.id.begin(), bristles.bent.id.begin() + seeded);
    bristles.bent.z.erase(bristles.bent.z.begin(), bristles.bent.z.begin() + seeded);
    bristles.rate.erase(bristles.rate.begin(), bristles.rate.begin() + seeded);
    record.bristle_start.erase(record.bristle_start.begin(), record.bristle_start.begin() + skip);
    for (int& start : record.bristle_start) start -= seeded;
  }
  block->q = std::move(record.q);
  block->v = std::move(record.v);
  block->xi = std::move(record.xi);
  block->vdot = std::move(record.vdot);
  block->bristles = std::move(record.bristles);
  block->bristle_start = std::move(record.bristle_start);
  block->present = true;
  if (index + 1 < static_cast<int>(blocks_.size())) {
    const VectorXd& next = blocks_[index + 1].seed.q;
    KNAP_CHECK(std::equal(next.begin(), next.end(), block->q.end() - nq_), "a block came out with other bits");
  }
}

void Trajectory::GetBristles(int k, BristleState* out) const {
  const Block& block = GetBlock(k);
  const int begin = block.bristle_start[k - block.first];
  const int end = block.bristle_start[k - block.first + 1];
  const BristleState& all = block.bristles;
  out->bent.id.assign(all.bent.id.begin() + begin, all.bent.id.begin() + end);
  out->bent.z.assign(all.bent.z.begin() + begin, all.bent.z.begin() + end);
  out->rate.assign(all.rate.begin() + begin, all.rate.begin() + end);
}

}  // namespace knap
