// SPDX-License-Identifier: Apache-2.0
#include "workbench/serve/http/connections.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <exception>
#include <functional>
#include <string_view>
#include <system_error>
#include <utility>

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

constexpr std::string_view kHeadEnd = "\r\n\r\n";
constexpr auto kEnding = 200ms;  // what a client may still take when the server ends
constexpr std::size_t kMegabyte = 1000000;
constexpr std::size_t kNeverEnds = 1000000;  // requests of one connection

/// "GET /api/state?x HTTP/1.1" -> "/api/state".
std::string_view path_of(std::string_view head) {
  const std::size_t begin = std::min(head.find(' '), head.size() - 1) + 1;
  return head.substr(begin, head.find_first_of(" ?\r", begin) - begin);
}

/// Nothing is compressed: the library would do it at the slowest setting (Brotli 11: 150 ms for the 50 kB of
/// uPlot, measured), for clients on the same machine.
void uncompressed(httplib::Request& request) {
  request.headers.erase("Accept-Encoding");
}

}  // namespace

struct PageServer::Connection {
  Connection(int open_socket, Clock::time_point end) : socket(open_socket), deadline(end) {}
  ~Connection() {
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket;
  std::string received;        ///< and not yet read
  Clock::time_point deadline;  ///< of its next request
  bool large = false;          ///< its next request
};

/// A connection as the HTTP library reads and writes it, for one request.
class PageServer::Stream : public httplib::Stream {
 public:
  Stream(PageServer& server, Connection& connection)
      : server_(server),
        connection_(connection),
        may_wait_(server.limits_.stalled),
        may_read_(server.limits_.head_bytes +
                  (connection.large ? server.limits_.large_bytes : server.limits_.small_bytes)) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override {
    pollfd one{connection_.socket, POLLRDHUP, 0};
    return ::poll(&one, 1, 0) == 0;  // the other side has not closed
  }

  ssize_t read(char* to, std::size_t size) override {
    std::string& received = connection_.received;
    if (size > may_read_) return broken();
    ssize_t count = 0;
    if (taken_ < received.size()) {
      count = static_cast<ssize_t>(std::min(size, received.size() - taken_));
      received.copy(to, static_cast<std::size_t>(count), taken_);
      taken_ += static_cast<std::size_t>(count);
    } else {
      received.clear();
      taken_ = 0;
      count = transfer(POLLIN, [&] { return ::recv(connection_.socket, to, size, MSG_DONTWAIT); });
    }
    if (count > 0) may_read_ -= static_cast<std::size_t>(count);
    return count;
  }

  ssize_t write(const char* from, std::size_t size) override {
    return transfer(POLLOUT,
                    [&] { return ::send(connection_.socket, from, size, MSG_DONTWAIT | MSG_NOSIGNAL); });
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override { get_local_ip_and_port(ip, port); }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip = "127.0.0.1";  // the only address that is bound
    port = 0;
  }
  socket_t socket() const override { return connection_.socket; }

  /// What the client has sent beyond this request stays for the next one. False where there can be none: this
  /// one did not come to its end.
  bool finish() {
    connection_.received.erase(0, taken_);
    return !broken_;
  }

 private:
  ssize_t broken() {
    broken_ = true;
    return -1;
  }

  template <class Transfer>
  ssize_t transfer(short event, Transfer&& bytes) {
    for (;;) {
      const ssize_t count = bytes();
      if (count >= 0) {
        moved_ += static_cast<std::size_t>(count);
        for (; moved_ >= kMegabyte; moved_ -= kMegabyte) may_wait_ += server_.limits_.for_each_megabyte;
        return count;
      }
      if (errno == EINTR) continue;
      if ((errno != EAGAIN && errno != EWOULDBLOCK) || !wait(event)) return broken();
    }
  }

  /// Waits until the client goes on. False where it has closed, has no time left, or the server ends.
  bool wait(short event) {
    while (may_wait_ > Clock::duration::zero()) {
      const auto begin = Clock::now();
      pollfd one{connection_.socket, event, 0};
      const auto most = std::chrono::ceil<milliseconds>(std::min<Clock::duration>(may_wait_, kEnding));
      const int ready = ::poll(&one, 1, static_cast<int>(most.count()));
      may_wait_ -= Clock::now() - begin;
      if (ready > 0) return true;
      if ((ready < 0 && errno != EINTR) || server_.ended_.load()) return false;
    }
    return false;
  }

  PageServer& server_;
  Connection& connection_;
  Clock::duration may_wait_;
  std::size_t may_read_;
  std::size_t moved_ = 0;  ///< bytes since the last megabyte
  std::size_t taken_ = 0;  ///< of what was received
  bool broken_ = false;
};

/// Takes the library's connections on its own thread: they only change hands there.
class PageServer::Queue : public httplib::TaskQueue {
 public:
  explicit Queue(PageServer& server) : server_(server) {}
  void enqueue(std::function<void()> take) override { take(); }
  void shutdown() override { server_.finish(); }

 private:
  PageServer& server_;
};

PageServer::PageServer(const ConnectionLimits& limits, IsLarge is_large)
    : limits_(limits), is_large_(is_large), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  new_task_queue = [this] { return new Queue(*this); };
  set_payload_max_length(limits.large_bytes);
  // Told to the client only.
  set_keep_alive_timeout(std::chrono::duration_cast<std::chrono::seconds>(limits.idle).count());
  set_keep_alive_max_count(kNeverEnds);
  waiting_ = std::thread([this] { wait_for_requests(); });
}

PageServer::~PageServer() {
  finish();
  ::close(wake_);
}

void PageServer::widen_backlog() const {
  // Linux takes the new length of a socket that listens already; where it does not, five it is.
  static_cast<void>(::listen(svr_sock_.load(), static_cast<int>(limits_.waiting)));
}

bool PageServer::process_and_close_socket(socket_t socket) {
  {
    const std::lock_guard lock(lock_);
    arrived_.push_back(std::make_unique<Connection>(socket, Clock::now() + limits_.stalled));
  }
  wake();
  return true;
}

void PageServer::wake() const {
  const std::uint64_t one = 1;
  static_cast<void>(::write(wake_, &one, sizeof one));  // fails only where it is awake already
}

void PageServer::wait_for_requests() {
  Connections waiting;  // the longest first
  std::vector<pollfd> polled;
  while (!ended_.load()) {
    {
      const std::lock_guard lock(lock_);
      waiting.splice(waiting.end(), arrived_);
    }
    while (waiting.size() > limits_.waiting) waiting.pop_front();
    auto next = Clock::now() + limits_.idle;
    polled.assign(1, {wake_, POLLIN, 0});
    for (const auto& one : waiting) {
      polled.push_back({one->socket, POLLIN, 0});
      next = std::min(next, one->deadline);
    }
    const auto most = std::chrono::ceil<milliseconds>(next - Clock::now());
    if (::poll(polled.data(), polled.size(), std::max(0, static_cast<int>(most.count()))) < 0) continue;
    std::uint64_t woken = 0;
    if (polled[0].revents != 0) static_cast<void>(::read(wake_, &woken, sizeof woken));
    auto one = waiting.begin();
    for (std::size_t i = 1; i < polled.size(); ++i) {
      const auto here = one++;
      if (polled[i].revents != 0) {
        receive(waiting, here);
      } else if (Clock::now() >= (*here)->deadline) {
        waiting.erase(here);
      }
    }
  }
}

void PageServer::receive(Connections& waiting, Connections::iterator place) {
  Connection& connection = **place;
  std::array<char, 4096> bytes{};
  const ssize_t count = ::recv(connection.socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    waiting.erase(place);
    return;
  }
  std::string& received = connection.received;
  // The head has a time of its own, however long the connection was open before.
  if (received.empty()) connection.deadline = std::min(connection.deadline, Clock::now() + limits_.stalled);
  const std::size_t seen = received.size() - std::min(received.size(), kHeadEnd.size() - 1);
  received.append(bytes.data(), static_cast<std::size_t>(count));
  const bool whole = received.find(kHeadEnd, seen) != std::string::npos;
  if (whole) offer(std::move(*place));
  if (whole || received.size() > limits_.head_bytes) waiting.erase(place);
}

void PageServer::offer(std::unique_ptr<Connection> connection) {
  connection->large = is_large_(path_of(connection->received));
  const std::lock_guard lock(lock_);
  if (ending_ || ready_.size() >= limits_.waiting) return;
  ready_.push_back(std::move(connection));
  if (ready_.size() > idle_threads_ && threads_.size() < limits_.threads) {
    threads_.emplace_back([this] { serve_requests(); });
  }
  offered_.notify_one();
}

void PageServer::serve_requests() {
  std::unique_lock lock(lock_);
  for (;;) {
    auto next = ready_.end();
    ++idle_threads_;
    offered_.wait(lock, [&] {
      next = std::find_if(ready_.begin(), ready_.end(),
                          [&](const auto& one) { return !one->large || large_ < limits_.large; });
      return ending_ || next != ready_.end();
    });
    --idle_threads_;
    if (ending_) return;
    std::unique_ptr<Connection> connection = std::move(*next);
    ready_.erase(next);
    const std::size_t large = connection->large ? 1 : 0;
    large_ += large;
    lock.unlock();
    serve(std::move(connection));
    lock.lock();
    large_ -= large;
    if (large > 0) offered_.notify_one();  // the next large one
  }
}

void PageServer::serve(std::unique_ptr<Connection> connection) {
  Stream stream(*this, *connection);
  bool closed = false;
  try {
    if (!process_request(stream, false, closed, uncompressed) || closed) return;
  } catch (const std::exception&) {
    return;  // out of memory, or a request that the library does not bear: this connection ends, no other
  }
  if (stream.finish()) keep(std::move(connection));
}

/// For the next request of the same client.
void PageServer::keep(std::unique_ptr<Connection> connection) {
  if (connection->received.find(kHeadEnd) != std::string::npos) {
    offer(std::move(connection));
    return;
  }
  connection->deadline = Clock::now() + (connection->received.empty() ? limits_.idle : limits_.stalled);
  {
    const std::lock_guard lock(lock_);
    if (ending_) return;
    arrived_.push_back(std::move(connection));
  }
  wake();
}

/// Ends what waits, and lets what is served end.
void PageServer::finish() {
  ended_.store(true);
  wake();
  if (waiting_.joinable()) waiting_.join();
  {
    const std::lock_guard lock(lock_);
    ending_ = true;
    ready_.clear();
    arrived_.clear();
  }
  offered_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

}  // namespace slipstack::workbench
