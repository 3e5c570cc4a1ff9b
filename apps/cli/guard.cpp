#include "guard.hpp"

#include <fmt/format.h>

#include <CLI/Error.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "output.hpp"
#include "stiction/core/file_fault.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::app {
namespace {

int fail(bool json, ExitCode code, std::string_view status, std::string_view message) {
  say(stderr, "stiction: {}\n", message);
  if (json) {
    nlohmann::ordered_json out;
    out["status"] = status;
    out["message"] = message;
    say(stdout, "{}\n", out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  return code;
}

/// Where the words of this program are explained.
std::string help_of(std::string_view program) {
  if (program == "stiction") return "`stiction --help` and `stiction COMMAND --help` say what there is";
  return fmt::format("`{} --help` says what there is", program);
}

int answer(std::string_view program, bool json, const std::function<int()>& body) {
  try {
    return body();
  } catch (const CLI::ParseError& e) {
    return fail(json, kBadInput, "InvalidInput", fmt::format("{}; {}", e.what(), help_of(program)));
  } catch (const core::InvalidInput& e) {
    return fail(json, kBadInput, "InvalidInput", e.what());
  } catch (const std::filesystem::filesystem_error& e) {
    return fail(json, kBadInput, "InvalidInput", core::to_invalid_input(e).what());
  } catch (const std::bad_alloc&) {
    return fail(json, kInternalError, "Error", "there is not enough memory for this");
  } catch (const std::exception& e) {
    return fail(json, kInternalError, "Error", e.what());
  }
}

}  // namespace

int guard(std::string_view program, int argc, char** argv, const std::function<int()>& body) {
  const bool json = std::any_of(argv + 1, argv + argc, [](const char* word) { return std::string_view(word) == "--json"; });
  open_output();
  begin_signals(json);
  const int code = answer(program, json, body);
  return close_output() || code != kDone ? code : kInternalError;
}

}  // namespace stiction::app
