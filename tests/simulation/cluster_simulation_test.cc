// The promise: whatever dies and whatever the network does, a run ends with the bits of an undisturbed one.
//
// KNAP_FIRST_SEED and KNAP_SEEDS choose other schedules, for a longer search or to repeat one that failed.
#include "tests/simulation/cluster_simulation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace knap {
namespace {

constexpr std::uint64_t kSeedsPerRange = 1000;

std::uint64_t ReadNumber(const char* variable, std::uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

class ClusterSimulationTest : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(ClusterSimulationTest, EveryScheduleEndsWithTheReferencesBits) {
  const std::uint64_t first = ReadNumber("KNAP_FIRST_SEED", 1 + GetParam() * kSeedsPerRange);
  const std::uint64_t count = ReadNumber("KNAP_SEEDS", kSeedsPerRange);
  SimulationReport sum;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const SimulationReport report = RunSimulation(seed, PlantedDefect::kNone);
    EXPECT_EQ(report.failure, "") << "repeat it with KNAP_FIRST_SEED=" << seed << " KNAP_SEEDS=1";
    sum.lives += report.lives;
    sum.worker_crashes += report.worker_crashes;
    sum.hangs += report.hangs;
    sum.freezes += report.freezes;
    sum.silences += report.silences;
    sum.cuts += report.cuts;
    sum.lacks += report.lacks;
    sum.failed_reads += report.failed_reads;
    sum.checks += report.checks;
    sum.torn_bytes += report.torn_bytes;
    sum.messages += report.messages;
    sum.simulated_s += report.simulated_s;
    sum.counters.computed += report.counters.computed;
    sum.counters.moved += report.counters.moved;
    sum.counters.copied += report.counters.copied;
    sum.counters.workers_refused += report.counters.workers_refused;
    sum.counters.reissued += report.counters.reissued;
    sum.counters.resent += report.counters.resent;
    sum.counters.duplicates += report.counters.duplicates;
    sum.counters.workers_lacking += report.counters.workers_lacking;
    sum.counters.workers_lost += report.counters.workers_lost;
    sum.counters.workers_stalled += report.counters.workers_stalled;
    sum.counters.refused.corrupt += report.counters.refused.corrupt;
  }
  const DispatchCounters& c = sum.counters;
  fmt::print(
      "{} schedules, {:.0f} s simulated, {} checks of what must always hold, {} messages to the coordinator, {} lives "
      "of "
      "it, {} torn bytes, {} failed reads; workers: {} crashes, {} hangs, {} freezes, {} silences, {} cuts one way, {} "
      "lacks; {} lost, {} stuck, {} refused; answers: {}, {} duplicates; "
      "requests: "
      "{} reissued, {} moved, {} copied, {} resent; {} messages corrupt\n",
      count, sum.simulated_s, sum.checks, sum.messages, sum.lives, sum.torn_bytes, sum.failed_reads, sum.worker_crashes,
      sum.hangs, sum.freezes, sum.silences, sum.cuts, sum.lacks, c.workers_lost, c.workers_stalled, c.workers_refused,
      c.computed, c.duplicates, c.reissued, c.moved, c.copied, c.resent, c.refused.corrupt);
  if (count < kSeedsPerRange) return;
  // The schedules are worth something only if all this happened, and often.
  EXPECT_GT(sum.lives, 1.2 * kSeedsPerRange);
  EXPECT_GT(sum.worker_crashes, kSeedsPerRange / 2);
  EXPECT_GT(sum.hangs, 100);
  EXPECT_GT(sum.freezes, kSeedsPerRange / 2);
  EXPECT_GT(sum.silences, kSeedsPerRange / 2);
  EXPECT_GT(sum.torn_bytes, 1000);
  EXPECT_GT(sum.failed_reads, 50);
  EXPECT_GT(sum.cuts, kSeedsPerRange / 2);
  EXPECT_GT(sum.counters.workers_lacking, 50);
  EXPECT_GT(sum.checks, sum.messages);
  EXPECT_GT(sum.counters.moved, kSeedsPerRange / 2);
  EXPECT_GT(sum.counters.copied, kSeedsPerRange / 5);
  EXPECT_GT(sum.counters.workers_refused, kSeedsPerRange / 20);
  EXPECT_GT(sum.counters.reissued, kSeedsPerRange / 2);
  EXPECT_GT(sum.counters.resent, kSeedsPerRange);
  EXPECT_GT(sum.counters.duplicates, kSeedsPerRange);
  EXPECT_GT(sum.counters.workers_lost, kSeedsPerRange / 2);
  EXPECT_GT(sum.counters.workers_stalled, 50);
  EXPECT_GT(sum.counters.refused.corrupt, kSeedsPerRange);
}

INSTANTIATE_TEST_SUITE_P(Seeds, ClusterSimulationTest, ::testing::Range<std::uint64_t>(0, 10));

// A simulator that finds nothing proves nothing: each of these defects must show within so many seeds, by its symptom.
struct Plant {
  const char* name;
  PlantedDefect defect;
  int seeds;
  const char* symptom;
};

class PlantedDefectTest : public ::testing::TestWithParam<Plant> {};

TEST_P(PlantedDefectTest, IsFound) {
  std::string failures;
  for (int seed = 1; seed <= GetParam().seeds; ++seed) {
    const SimulationReport report = RunSimulation(static_cast<std::uint64_t>(seed), GetParam().defect);
    if (report.failure.find(GetParam().symptom) != std::string::npos) {
      fmt::print("found by seed {}: {}\n", seed, report.failure);
      return;
    }
    if (!report.failure.empty()) failures += std::to_string(seed) + ": " + report.failure + "\n";
  }
  FAIL() << "found by none of " << GetParam().seeds << " seeds; what they found instead:\n" << failures;
}

INSTANTIATE_TEST_SUITE_P(
    Defects, PlantedDefectTest,
    ::testing::Values(Plant{"AcknowledgesBeforeJournal", PlantedDefect::kAcknowledgesBeforeJournal, 20,
                            "before the disk had it"},
                      Plant{"SyncDoesNothing", PlantedDefect::kSyncDoesNothing, 20, "before the disk had it"},
                      Plant{"IgnoresDigests", PlantedDefect::kIgnoresDigests, 100, "other bits than the reference's"},
                      Plant{"NoStepProgress", PlantedDefect::kNoStepProgress, 2000, "has not ended"},
                      Plant{"LeasesNeverExpire", PlantedDefect::kLeasesNeverExpire, 100, "after its death"},
                      Plant{"ReadsAreShort", PlantedDefect::kReadsAreShort, 1000, "is lost"}),
    [](const auto& plant) { return std::string(plant.param.name); });

}  // namespace
}  // namespace knap
