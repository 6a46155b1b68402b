// A disk that holds one journal and forgets, in a crash, what was not synced.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>

#include "coordinator/run_directory/append_file.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {

class SimulatedDisk {
 public:
  bool exists() const { return exists_; }
  const std::string& bytes() const { return bytes_; }

  // A file made in one step, by renaming: there as a whole, durable, or not at all.
  void Create(std::string bytes);

  void Write(std::string_view bytes) { bytes_ += bytes; }
  void Truncate(std::size_t size) { bytes_.resize(size); }
  void Sync();

  // Keeps what was synced. Of what was written since, a part survives that may end anywhere and be damaged or followed
  // by zeros, as file systems leave it. `draw` gives numbers in [0, 1).
  void Crash(const std::function<double()>& draw);

  // Whether an answer to this request is in a record that was synced.
  bool HoldsAnswer(const ContentId& id) const { return answers_.count(id) != 0; }

  // The answer to this request may be forgotten elsewhere: from now on it must stay in a synced record.
  void Rely(const ContentId& id) { relied_on_.insert(id); }
  // Relied upon, and gone; empty when there is none.
  const std::optional<ContentId>& lost() const { return lost_; }

 private:
  void ReadAnswers(std::size_t begin);

  bool exists_ = false;
  std::string bytes_;    // as a reader sees them
  std::string durable_;  // as a crash leaves them at least
  std::unordered_set<ContentId, ContentIdHash> answers_;
  std::unordered_set<ContentId, ContentIdHash> relied_on_;
  std::optional<ContentId> lost_;
};

// The journal's file on it. `on_effect` is called before anything is done to the disk and may throw: the writer dies.
// A write during which it dies reaches the disk in part.
class SimulatedFile : public AppendFile {
 public:
  struct Hooks {
    std::function<bool()> is_alive;  // a dead writer's writes reach nothing
    std::function<void()> on_effect;
    std::function<double()> draw;
    bool read_fails = false;         // as a disk that says EIO
    bool read_is_short = false;      // a planted defect: a failed read passes for the end of the file
    bool sync_does_nothing = false;  // a planted defect
  };

  SimulatedFile(SimulatedDisk* disk, Hooks hooks) : disk_(disk), hooks_(std::move(hooks)) {}

  const std::filesystem::path& path() const override { return path_; }
  std::string ReadAll() const override;
  void Write(std::string_view bytes) override;
  void Sync() override;
  void Truncate(std::uint64_t size) override;

 private:
  SimulatedDisk* disk_;
  Hooks hooks_;
  std::filesystem::path path_ = "journal";
};

}  // namespace knap
