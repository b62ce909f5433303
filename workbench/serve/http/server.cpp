// SPDX-License-Identifier: Apache-2.0
// Requests are checked (guard.h), taken apart, and answered by the workspace. This source and connections.cpp
// alone see the HTTP library.
#include "workbench/serve/http/server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <string_view>
#include <thread>

// The headers of the HTTP library define this macro, which is a name in Eigen.
#undef _res

#include "workbench/base/errors.h"
#include "workbench/base/text.h"
#include "workbench/can/client/socket_link.h"
#include "workbench/model/expression/definition.h"
#include "workbench/report/effect_page.h"
#include "workbench/serve/http/connections.h"
#include "workbench/serve/http/guard.h"
#include "workbench/serve/http/open_page.h"
#include "workbench/serve/http/pages.h"
#include "workbench/serve/http/upload.h"
#include "workbench/serve/session/hand_changes.h"
#include "workbench/serve/session/workspace.h"
#include "workbench/serve/views/catalogue_json.h"

namespace slipstack::workbench {
namespace {

using namespace std::chrono_literals;
using httplib::Request;
using httplib::Response;
using nlohmann::json;

constexpr auto kHeartbeat = 2s;  // of the events, so that a lost page is noticed
/// Between two tellings of how far a job is. A page that draws them takes 10 ms of processor time each, which
/// the job lacks where there are two processors (35 in a diagnosis of 1.5 s; Chromium 2026, tracing).
constexpr auto kBetweenProgress = 150ms;

constexpr int kBadRequest = 400;
constexpr int kForbidden = 403;
constexpr int kNotFound = 404;
constexpr int kFault = 500;

void answer_json(Response& response, const json& value) {
  response.set_content(value.dump(-1, ' ', false, json::error_handler_t::replace), "application/json");
}

void answer_error(Response& response, int status, const std::string& what) {
  response.status = status;
  answer_json(response, {{"error", printable(what)}});
}

/// Runs a handler; what it throws becomes one line for the page.
void guarded(Response& response, const std::function<void()>& handler) {
  try {
    handler();
  } catch (const DefinitionError& error) {
    answer_error(response, kBadRequest, error.what());
    answer_json(response, {{"error", printable(error.what())}, {"picture", error.picture()}});
  } catch (const InputError& error) {
    answer_error(response, kBadRequest, error.what());
  } catch (const UsageError& error) {
    answer_error(response, kBadRequest, error.what());
  } catch (const json::exception& error) {
    answer_error(response, kBadRequest, fmt::format("the request is not understood: {}", error.what()));
  } catch (const std::exception& error) {
    answer_error(response, kFault, error.what());
  }
}

int number(const Request& request, const char* name, int otherwise = 0) {
  if (!request.has_param(name)) return otherwise;
  const std::string text = request.get_param_value(name);
  double value = 0.0;
  const char* end = parse_double(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || value != static_cast<double>(static_cast<int>(value))) {
    throw UsageError(fmt::format("{}: must be a whole number", name));
  }
  return static_cast<int>(value);
}

double real(const Request& request, const char* name, double otherwise) {
  if (!request.has_param(name)) return otherwise;
  const std::string text = request.get_param_value(name);
  double value = 0.0;
  if (parse_double(text.data(), text.data() + text.size(), value) == nullptr) {
    throw UsageError(fmt::format("{}: must be a number", name));
  }
  return value;
}

json body_of(const Request& request) {
  return request.body.empty() ? json::object() : json::parse(request.body);
}

void answer_bytes(Response& response, const Bytes& bytes) {
  response.set_content(bytes.text(), "application/octet-stream");
}

/// What a page has got of a live controller.
struct SeenSignals {
  std::uint64_t connection = 0;
  std::uint64_t end = 0;
};

std::string event(const char* name, const json& value) {
  return fmt::format("event: {}\ndata: {}\n\n", name,
                     value.dump(-1, ' ', false, json::error_handler_t::replace));
}

/// What is new of the signals of a live controller; empty where nothing is.
std::string new_signals(const Workspace& workspace, SeenSignals& seen) {
  const std::shared_ptr<LiveNode> live = workspace.live();
  if (!live) return "";
  if (live->number() != seen.connection) seen = {live->number(), 0};
  if (live->end() == seen.end) return "";
  const json signals = live->since(seen.end);
  seen.end = signals.at("end");
  return event("live", signals);
}

/// Sends the state and the signals of a live controller whenever they changed, as server-sent events.
void stream_events(Workspace& workspace, Response& response) {
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(
      "text/event-stream",
      [&workspace, follower = workspace.events().follow(), seen = Events::Numbers{0, 0, 0},
       signals = SeenSignals{},
       progress_from = Events::Clock::time_point{}](std::size_t, httplib::DataSink& sink) mutable {
        const std::optional<Events::Numbers> now =
            workspace.events().wait(follower, seen, kHeartbeat, progress_from);
        if (!now) {
          sink.done();
          return false;
        }
        std::string text = ":\n\n";
        if (now->state != seen.state || now->progress != seen.progress) {
          text += event("state", workspace.state());
          progress_from = Events::Clock::now() + kBetweenProgress;
        }
        if (now->live != seen.live) text += new_signals(workspace, signals);
        seen = *now;
        return sink.write(text.data(), text.size());
      });
}

using Handler = std::function<void(const Request&, Response&)>;

void get(httplib::Server& server, const char* path, Handler handler) {
  server.Get(path, [handler = std::move(handler)](const Request& request, Response& response) {
    guarded(response, [&] { handler(request, response); });
  });
}

/// A change: what it answers with is the state after it.
void post(httplib::Server& server, const char* path, Workspace& workspace,
          std::function<void(const Request&)> handler) {
  server.Post(path, [handler = std::move(handler), &workspace](const Request& request, Response& response) {
    guarded(response, [&] {
      handler(request);
      answer_json(response, workspace.state());
    });
  });
}

void serve_pictures(httplib::Server& server, Workspace& workspace) {
  get(server, "/api/picture", [&](const Request& request, Response& response) {
    answer_bytes(response, workspace.picture(static_cast<std::size_t>(number(request, "log")),
                                             request.get_param_value("signal"), real(request, "from", 0.0),
                                             real(request, "to", 0.0),
                                             static_cast<std::size_t>(number(request, "points", 2000))));
  });
  get(server, "/api/rows",
      [&](const Request&, Response& response) { answer_bytes(response, workspace.rows()); });
  get(server, "/api/model", [&](const Request& request, Response& response) {
    answer_bytes(response, workspace.model(number(request, "version")));
  });
  get(server, "/api/charts", [&](const Request& request, Response& response) {
    answer_json(response, workspace.charts(number(request, "version"), number(request, "other")));
  });
  get(server, "/api/worth", [&](const Request& request, Response& response) {
    answer_json(response, workspace.worth(number(request, "version")));
  });
  get(server, "/api/with", [&](const Request& request, Response& response) {
    answer_json(response,
                workspace.with_candidate(number(request, "version"), request.get_param_value("effect")));
  });
  get(server, "/api/adjustable", [&](const Request& request, Response& response) {
    answer_json(response, workspace.adjustable_parameters(number(request, "version")));
  });
  server.Post("/api/bent", [&](const Request& request, Response& response) {
    guarded(response, [&] {
      const json body = body_of(request);
      answer_bytes(response, workspace.bent(body.at("version"), body.at("changes")));
    });
  });
}

void serve_models(httplib::Server& server, Workspace& workspace) {
  post(server, "/api/fit", workspace, [&](const Request& request) {
    workspace.fit(body_of(request).at("effects").get<std::vector<std::string>>());
  });
  post(server, "/api/add", workspace,
       [&](const Request& request) { workspace.add(body_of(request).at("effect")); });
  post(server, "/api/remove", workspace,
       [&](const Request& request) { workspace.remove(body_of(request).at("effect")); });
  post(server, "/api/diagnose", workspace, [&](const Request& request) {
    workspace.diagnose(body_of(request).value("user_effects", std::vector<std::string>{}));
  });
  post(server, "/api/keep", workspace, [&](const Request& request) {
    const json body = body_of(request);
    workspace.keep_bent(body.at("version"), body.at("changes"));
  });
  post(server, "/api/cancel", workspace, [&](const Request&) { workspace.jobs().cancel(); });
  post(server, "/api/select", workspace,
       [&](const Request& request) { workspace.select(body_of(request).at("version")); });
  post(server, "/api/undo", workspace, [&](const Request&) { workspace.undo(); });
  post(server, "/api/redo", workspace, [&](const Request&) { workspace.redo(); });
}

void serve_experiments(httplib::Server& server, Workspace& workspace) {
  post(server, "/api/simulate", workspace, [&](const Request& request) {
    const json body = body_of(request);
    workspace.start_simulated_axis({body.value("seed", std::uint64_t{1}), body.value("effects", "random"),
                                    body.value("strength", 0.0), body.value("seconds", 30.0),
                                    body.value("setup", SimulatedAxis{}.setup)});
  });
  post(server, "/api/plan", workspace, [&](const Request& request) { workspace.plan(body_of(request)); });
  post(server, "/api/run", workspace, [&](const Request&) { workspace.run_plan(); });
  post(server, "/api/deploy", workspace, [&](const Request& request) {
    const json body = body_of(request);
    workspace.deploy(body.at("version"), body.value("bus", ""), body.value("node", 5),
                     body.value("travel_m", 0.0));
  });
  get(server, "/api/tracking",
      [&](const Request&, Response& response) { answer_json(response, workspace.tracking()); });
  get(server, "/api/controller", [&](const Request& request, Response& response) {
    answer_json(response, workspace.controller(number(request, "version"), request.get_param_value("bus"),
                                               number(request, "node", 5)));
  });
}

void serve_live(httplib::Server& server, Workspace& workspace) {
  post(server, "/api/live/connect", workspace, [&](const Request& request) {
    const json body = body_of(request);
    LiveNode::Target target;
    target.bus = body.value("bus", target.bus);
    target.node = body.value("node", target.node);
    target.rate_Hz = body.value("rate_Hz", target.rate_Hz);
    workspace.connect(target);
  });
  post(server, "/api/live/disconnect", workspace, [&](const Request&) { workspace.disconnect(); });
  post(server, "/api/live/record", workspace, [&](const Request&) { workspace.start_recording(); });
  post(server, "/api/live/keep", workspace,
       [&](const Request& request) { workspace.keep_recording(body_of(request).value("alone", false)); });
  post(server, "/api/live/move", workspace, [&](const Request& request) {
    const json body = body_of(request);
    workspace.move_axis(body.at("travel_m"), body.value("times", 1));
  });
  post(server, "/api/live/reset", workspace, [&](const Request&) { workspace.reset_fault(); });
  get(server, "/api/live/plan",
      [&](const Request&, Response& response) { answer_json(response, workspace.plan_on_controller()); });
  post(server, "/api/live/run", workspace, [&](const Request& request) {
    workspace.run_plan_on_controller(body_of(request).value("alone", false));
  });
  get(server, "/api/live/interfaces",
      [](const Request&, Response& response) { answer_json(response, can_interfaces()); });
}

void serve_files(httplib::Server& server, Workspace& workspace) {
  server.Post("/api/upload", [&](const Request& request, Response& response) {
    guarded(response, [&] {
      answer_json(response, take_upload(workspace, request.get_param_value("name"), request.body,
                                        request.get_param_value("profile")));
    });
  });
  post(server, "/api/close", workspace,
       [&](const Request& request) { workspace.remove_log(body_of(request).at("log").get<std::size_t>()); });
  get(server, "/api/notes", [&](const Request&, Response& response) {
    answer_json(response, {{"text", workspace.notes()}});
  });
  post(server, "/api/notes", workspace,
       [&](const Request& request) { workspace.set_notes(body_of(request).at("text")); });
  get(server, "/api/download", [&](const Request& request, Response& response) {
    json options = json::object();
    if (request.has_param("from")) options["from_s"] = real(request, "from", 0.0);
    if (request.has_param("to")) options["to_s"] = real(request, "to", 0.0);
    const Download file =
        workspace.download(request.get_param_value("what"), number(request, "version"), options);
    response.set_header("Content-Disposition", "attachment; filename=\"" + file.name + "\"");
    response.set_content(file.content, file.type);
  });
}

void serve_page(httplib::Server& server) {
  for (const Page& page : pages()) {
    server.Get(page.path, [page](const Request&, Response& response) {
      response.set_header("Cache-Control", "no-cache");
      response.set_content(page.content.data(), page.content.size(), page.type);
    });
  }
}

/// Everything but the page itself, which holds no secret, needs the token.
void check_requests(httplib::Server& server, const Guard& guard) {
  server.set_default_headers({{"Content-Security-Policy", kContentPolicy},
                              {"X-Content-Type-Options", "nosniff"},
                              {"X-Frame-Options", "DENY"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cross-Origin-Opener-Policy", "same-origin"},
                              {"Cross-Origin-Resource-Policy", "same-origin"}});
  server.set_pre_routing_handler([&guard](const Request& request, Response& response) {
    const bool api = request.path.rfind("/api/", 0) == 0;
    const bool known = guard.knows_host(request.get_header_value("Host")) &&
                       guard.knows_origin(request.get_header_value("Origin")) &&
                       (!api || guard.knows_token(request.get_header_value("Authorization")));
    if (known) return httplib::Server::HandlerResponse::Unhandled;
    answer_error(response, kForbidden, "not allowed: open the address that slipstack serve printed");
    return httplib::Server::HandlerResponse::Handled;
  });
  server.set_error_handler([](const Request&, Response& response) {
    if (response.status == kNotFound && response.body.empty()) answer_error(response, kNotFound, "not found");
  });
}

bool is_large(std::string_view path) {
  return path == "/api/upload" || path == "/api/download";
}

std::atomic<bool> stop_asked{false};
void on_signal(int) {
  stop_asked.store(true);
}

}  // namespace

void serve_pages(Workspace& workspace, const ServerOptions& options) {
  PageServer server({}, is_large);
  // Head and body are two writes: without this the second waits for the acknowledgement of the first, 40 ms.
  server.set_tcp_nodelay(true);
  const int port = options.port == 0                                ? server.bind_to_any_port("127.0.0.1")
                   : server.bind_to_port("127.0.0.1", options.port) ? options.port
                                                                    : -1;
  if (port <= 0) {
    throw UsageError(
        fmt::format("--port {}: cannot be bound; leave it out for any that is free", options.port));
  }
  server.widen_backlog();
  const Guard guard(port);
  check_requests(server, guard);
  serve_page(server);
  serve_pictures(server, workspace);
  serve_models(server, workspace);
  serve_experiments(server, workspace);
  serve_live(server, workspace);
  serve_files(server, workspace);
  get(server, "/api/state",
      [&](const Request&, Response& response) { answer_json(response, workspace.state()); });
  get(server, "/api/catalogue",
      [](const Request&, Response& response) { answer_json(response, catalogue_json()); });
  get(server, "/api/events", [&](const Request&, Response& response) { stream_events(workspace, response); });
  const std::string address = fmt::format("http://127.0.0.1:{}/#token={}", port, guard.token());
  std::optional<OpenPage> opened;
  if (options.open) opened.emplace(workspace.folder(), address);
  ::signal(SIGINT, on_signal);
  ::signal(SIGTERM, on_signal);
  fmt::print("{}\nends with Ctrl-C\n", address);
  std::fflush(stdout);
  std::atomic<bool> ended{false};
  std::thread listening([&] {
    server.listen_after_bind();
    ended.store(true);
  });
  // A server that does not listen yet is not stopped by stop().
  while (!ended.load() && (!stop_asked.load() || !server.is_running())) std::this_thread::sleep_for(50ms);
  workspace.jobs().cancel();
  workspace.events().close();
  server.stop();
  listening.join();
}

}  // namespace slipstack::workbench
