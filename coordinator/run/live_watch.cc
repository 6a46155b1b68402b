#include "coordinator/run/live_watch.h"

#include <chrono>
#include <functional>
#include <utility>
#include <vector>

#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/report_sources.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "coordinator/watch/status_text.h"
#include "lcmtypes/wire/open_transport.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {
namespace {

constexpr std::int64_t kReplays = 2;
constexpr std::int64_t kListenUs = 100'000;
constexpr std::int64_t kForgetEveryUs = 1'000'000;
constexpr std::int64_t kReadingUs = 60'000'000;  // a page that is open asks every two seconds, on a busy machine later
constexpr auto kLongestHandOver = std::chrono::seconds(60);

LiveDocument MakeDocument(const LoadedScenario& scenario, const RunDirectory& run, const Problem& problem,
                          RolloutModel& model) {
  ReportSource source = MakeReportSource(scenario, run, problem, model, kReplays);
  auto make_test = [source, task = CalcScenarioId(EncodeBundle(ListTaskFiles(scenario)))](
                       const std::string& name, const std::vector<double>& theta) {
    return MakeReportedTest(source, task, name, theta, {});
  };
  return {std::move(source), std::move(make_test)};
}

}  // namespace

LiveWatch::LiveWatch(const ListenAddress& address, const LoadedScenario& scenario, const RunDirectory& run,
                     const std::string& lcm_url, const std::string& key_file)
    : run_(run),
      problem_(MakeProblem(scenario.parsed.scene, scenario.files)),
      model_(scenario.files),
      view_(key_file.empty() ? RunKey() : RunKey::ReadFile(key_file)),
      document_(MakeDocument(scenario, run_, problem_, model_)),
      transport_(OpenTransport(lcm_url, ClusterView::ListChannels(), &clock_)),
      server_(std::make_unique<PageServer>(
          address,
          ServedPage{[this] { return ServePage(); }, [this](const std::string& seen) { return ServeNews(seen); }})),
      listener_([this] { Listen(); }) {}

LiveWatch::~LiveWatch() {
  server_.reset();
  stop_ = true;
  listener_.join();
}

void LiveWatch::Listen() {
  std::int64_t forget_us = clock_.now_us() + kForgetEveryUs;
  while (!stop_) {
    const std::optional<Message> message = transport_->Receive(kListenUs);
    const std::scoped_lock lock(view_mutex_);
    if (message) view_.Handle(*message);
    if (clock_.now_us() < forget_us) continue;
    view_.Forget(clock_.now_us());
    forget_us = clock_.now_us() + kForgetEveryUs;
  }
}

nlohmann::ordered_json LiveWatch::MakeStatus() {
  const std::scoped_lock lock(view_mutex_);
  return MakeStatusJson(view_, {}, clock_.now_us(), "");
}

std::string LiveWatch::ServePage() {
  {
    const std::scoped_lock lock(readers_mutex_);
    if (report_) {
      handed_over_ = true;
      changed_.notify_all();
      return ReadFile(*report_);
    }
    asked_us_ = clock_.now_us();
  }
  const nlohmann::ordered_json status = MakeStatus();
  const std::scoped_lock lock(document_mutex_);
  return document_.MakePage(status);
}

std::string LiveWatch::ServeNews(const std::string& seen) {
  {
    const std::scoped_lock lock(readers_mutex_);
    if (report_) return MakeJsonText({{"ended", true}}, -1);
    asked_us_ = clock_.now_us();
  }
  const nlohmann::ordered_json status = MakeStatus();
  const std::scoped_lock lock(document_mutex_);
  return document_.MakeNews(status, seen);
}

void LiveWatch::HandOver(const std::filesystem::path& report) {
  std::unique_lock lock(readers_mutex_);
  report_ = report;
  if (asked_us_ < 0 || clock_.now_us() - asked_us_ > kReadingUs) return;
  changed_.wait_for(lock, kLongestHandOver, [this] { return handed_over_; });
}

}  // namespace knap
