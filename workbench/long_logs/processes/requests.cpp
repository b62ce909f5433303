// SPDX-License-Identifier: Apache-2.0
#include "workbench/long_logs/processes/requests.h"

#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>

#include "workbench/base/errors.h"

namespace slipstack::workbench {
namespace {

using nlohmann::json;

std::string packed(const json& value) {
  const std::vector<std::uint8_t> bytes = json::to_cbor(value);
  return {bytes.begin(), bytes.end()};
}

json unpacked(const std::string& bytes) {
  return json::from_cbor(bytes.begin(), bytes.end());
}

/// {"answer": ...}, or what was thrown.
json outcome(const std::function<json()>& work) {
  try {
    return {{"answer", work()}};
  } catch (const InputError& error) {
    return {{"unusable", error.what()}};
  } catch (const std::bad_alloc&) {
    return {{"failed", "out of memory"}};
  } catch (const std::exception& error) {
    return {{"failed", error.what()}};
  }
}

}  // namespace

std::vector<json> ask(ProcessGroup& group, const json& request, const std::function<json()>& own) {
  if (group.size() == 1) return {own()};
  group.broadcast(packed(request), 0);
  json mine;
  std::exception_ptr failed;
  try {
    mine = own();
  } catch (...) {
    failed = std::current_exception();
  }
  const std::vector<std::string> messages = group.gather({});
  if (failed) std::rethrow_exception(failed);
  std::vector<json> answers{std::move(mine)};
  for (std::size_t rank = 1; rank < messages.size(); ++rank) {
    json reply = unpacked(messages[rank]);
    if (reply.contains("unusable")) throw InputError(reply["unusable"].get<std::string>());
    if (reply.contains("failed")) throw std::runtime_error(reply["failed"].get<std::string>());
    answers.push_back(std::move(reply["answer"]));
  }
  return answers;
}

void serve(ProcessGroup& group, const std::function<json(const json& request)>& work) {
  for (;;) {
    const json request = unpacked(group.broadcast({}, 0));
    if (request.is_null()) return;
    group.gather(packed(outcome([&] { return work(request); })));
  }
}

Dismissal::~Dismissal() {
  if (group_.size() > 1) group_.broadcast(packed(nullptr), 0);
}

}  // namespace slipstack::workbench
