#include "coordinator/run/answer_journal.h"

#include <bit>
#include <cstddef>
#include <stdexcept>

namespace knap {
namespace {

void AppendInteger(std::uint64_t value, int bytes, std::string* out) {
  for (int i = 0; i < bytes; ++i) out->push_back(static_cast<char>((value >> (8 * i)) & 0xff));
}

void AppendDouble(double value, std::string* out) { AppendInteger(std::bit_cast<std::uint64_t>(value), 8, out); }

class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  bool done() const { return rest_.empty(); }

  std::string_view Take(std::size_t size) {
    if (size > rest_.size()) throw std::runtime_error("journal: a record of answers ends too early");
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }

  std::uint64_t TakeInteger(int bytes) {
    const std::string_view taken = Take(static_cast<std::size_t>(bytes));
    std::uint64_t value = 0;
    for (int i = bytes - 1; i >= 0; --i)
      value = (value << 8) | static_cast<unsigned char>(taken[static_cast<std::size_t>(i)]);
    return value;
  }

  double TakeDouble() { return std::bit_cast<double>(TakeInteger(8)); }

  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

JournaledAnswer TakeAnswer(ByteReader* reader) {
  JournaledAnswer answer;
  for (std::uint8_t& byte : answer.id) byte = static_cast<std::uint8_t>(reader->TakeInteger(1));
  RolloutOutcome& outcome = answer.outcome;
  RolloutCertificate& certificate = outcome.certificate;
  outcome.loss = reader->TakeDouble();
  certificate.worst_residual = reader->TakeDouble();
  certificate.loss_error = reader->TakeDouble();
  certificate.penetration = reader->TakeDouble();
  certificate.largest_force = reader->TakeDouble();
  outcome.forward_s = reader->TakeDouble();
  outcome.gradient_s = reader->TakeDouble();
  certificate.subdivided_steps = static_cast<std::int32_t>(reader->TakeInteger(4));
  certificate.contact_onsets = static_cast<std::int32_t>(reader->TakeInteger(4));
  outcome.steps = static_cast<std::int32_t>(reader->TakeInteger(4));
  const std::uint64_t flags = reader->TakeInteger(4);
  outcome.success = (flags & 1U) != 0;
  certificate.finite = (flags & 2U) != 0;
  certificate.converged = (flags & 4U) != 0;
  certificate.gradient_reliable = (flags & 8U) != 0;
  certificate.distrust = reader->Take(static_cast<std::size_t>(reader->TakeInteger(4)));
  const std::uint64_t size = reader->TakeInteger(4);
  for (std::uint64_t i = 0; i < size; ++i) outcome.gradient.push_back(reader->TakeDouble());
  return answer;
}

}  // namespace

std::string EncodeAnswers(std::span<const JournaledAnswer> answers) {
  std::string bytes;
  for (const auto& [id, outcome] : answers) {
    for (const std::uint8_t byte : id) bytes.push_back(static_cast<char>(byte));
    const RolloutCertificate& certificate = outcome.certificate;
    for (const double value :
         {outcome.loss, certificate.worst_residual, certificate.loss_error, certificate.penetration,
          certificate.largest_force, outcome.forward_s, outcome.gradient_s}) {
      AppendDouble(value, &bytes);
    }
    for (const std::int32_t value : {certificate.subdivided_steps, certificate.contact_onsets, outcome.steps}) {
      AppendInteger(static_cast<std::uint32_t>(value), 4, &bytes);
    }
    const std::uint32_t flags = (outcome.success ? 1U : 0U) | (certificate.finite ? 2U : 0U) |
                                (certificate.converged ? 4U : 0U) | (certificate.gradient_reliable ? 8U : 0U);
    AppendInteger(flags, 4, &bytes);
    AppendInteger(certificate.distrust.size(), 4, &bytes);
    bytes += certificate.distrust;
    AppendInteger(outcome.gradient.size(), 4, &bytes);
    for (const double value : outcome.gradient) AppendDouble(value, &bytes);
  }
  return bytes;
}

std::vector<JournaledAnswer> DecodeAnswers(std::string_view bytes) {
  std::vector<JournaledAnswer> answers;
  for (ByteReader reader(bytes); !reader.done();) answers.push_back(TakeAnswer(&reader));
  return answers;
}

JournaledService::JournaledService(Dispatcher* dispatcher, Journal* journal, std::vector<std::string> payloads)
    : dispatcher_(dispatcher), journal_(journal), payloads_(std::move(payloads)) {
  for (const std::string_view payload : payloads_) {
    for (ByteReader reader(payload); !reader.done();) {
      const std::string_view begin = reader.rest();
      const ContentId id = TakeAnswer(&reader).id;
      earlier_[id] = begin.substr(0, begin.size() - reader.rest().size());
    }
  }
  dispatcher_->set_on_result([this](const RolloutReport& report) {
    ++current_;
    if (on_answer_) on_answer_(report);
    pending_.push_back({report.id, *report.outcome});
  });
  dispatcher_->set_on_commit([this] { Flush(); });
}

std::vector<RolloutOutcome> JournaledService::Evaluate(std::span<const RolloutQuery> queries) {
  total_ += static_cast<std::int64_t>(queries.size());
  std::vector<RolloutOutcome> outcomes(queries.size());
  std::vector<RolloutQuery> asked;
  std::vector<std::size_t> places;  // of their answers
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const ContentId id = dispatcher_->CalcId(queries[i]);
    distinct_.insert(id);
    if (const auto known = earlier_.find(id); known != earlier_.end()) {
      ByteReader reader(known->second);
      outcomes[i] = TakeAnswer(&reader).outcome;
    } else {
      asked.push_back(queries[i]);
      places.push_back(i);
    }
  }
  try {
    std::vector<RolloutOutcome> answers = dispatcher_->Evaluate(asked);
    for (std::size_t k = 0; k < places.size(); ++k) outcomes[places[k]] = std::move(answers[k]);
    current_ = 0;
    finished_ = total_;
    return outcomes;
  } catch (...) {
    Flush();  // what came before the failure needs not be asked again
    throw;
  }
}

void JournaledService::Flush() {
  if (pending_.empty()) return;
  // Cleared first: after a failed write the journal takes no more, and the error must not repeat from a handler.
  const std::string payload = EncodeAnswers(std::exchange(pending_, {}));
  journal_->Append(payload);
}

}  // namespace knap
