// The tcpq reader: the first byte of an input says into which pieces the rest is cut.
#include <algorithm>

#include "lcmtypes/wire/tcpq_stream.h"
#include "tests/fuzz/fuzz_target.h"

namespace {

struct Parsed {
  std::string messages;  // encoded again, one behind the other
  bool broken = false;
};

Parsed Parse(const char* bytes, std::size_t size, std::size_t cut) {
  Parsed parsed;
  knap::TcpqReader reader(knap::kTcpqClientMagic);
  for (std::size_t i = 0; i < size; i += cut) {
    reader.Append(bytes + i, std::min(cut, size - i));
    while (const auto message = reader.Take()) {
      parsed.messages +=
          knap::EncodeTcpqMessage(message->type, message->channel, message->data.data(), message->data.size());
    }
  }
  parsed.broken = reader.broken();
  return parsed;
}

}  // namespace

std::vector<std::string> MakeSeeds() {
  const std::string hello = knap::EncodeTcpqHello(knap::kTcpqClientMagic);
  const std::uint8_t data[] = {1, 2, 3, 4, 5};
  const std::string publish = knap::EncodeTcpqMessage(knap::TcpqType::kPublish, "KNAP_RESULT", data, sizeof(data));
  const std::string subscribe = knap::EncodeTcpqMessage(knap::TcpqType::kSubscribe, ".*", nullptr, 0);
  const std::string unsubscribe = knap::EncodeTcpqMessage(knap::TcpqType::kUnsubscribe, ".*", nullptr, 0);
  return {'\1' + hello + publish, '\3' + hello + subscribe + publish + publish + unsubscribe, '\7' + hello};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const char* bytes = reinterpret_cast<const char*>(data) + 1;
  const Parsed whole = Parse(bytes, size - 1, size);
  const Parsed pieces = Parse(bytes, size - 1, 1 + data[0] % 64);
  Require(whole.messages == pieces.messages && whole.broken == pieces.broken, "pieces do not matter");
  if (whole.messages.empty()) return 0;
  Require(std::string(bytes + 8, size - 9).compare(0, whole.messages.size(), whole.messages) == 0,
          "what is read is what was written");
  return 0;
}
