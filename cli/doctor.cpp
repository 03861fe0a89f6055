#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "cli/build_facts.h"
#include "cli/commands.h"
#include "cli/terminal.h"

namespace afptraj::cli {
namespace {

using Facts = std::vector<std::pair<std::string, std::string>>;

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  }
  return "unknown";
}

std::string cpu_features() {
  std::string text;
#if defined(__x86_64__)
  const auto add = [&](bool has, const char* name) {
    if (has) text += (text.empty() ? "" : " ") + std::string(name);
  };
  add(__builtin_cpu_supports("sse4.2") != 0, "SSE4.2");
  add(__builtin_cpu_supports("avx") != 0, "AVX");
  add(__builtin_cpu_supports("avx2") != 0, "AVX2");
  add(__builtin_cpu_supports("fma") != 0, "FMA");
  add(__builtin_cpu_supports("avx512f") != 0, "AVX-512F");
  add(__builtin_cpu_supports("avx512dq") != 0, "AVX-512DQ");
#endif
  return text.empty() ? "none that afptraj looks for" : text;
}

int usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return ::sched_getaffinity(0, sizeof set, &set) == 0
             ? CPU_COUNT(&set)
             : static_cast<int>(std::thread::hardware_concurrency());
}

std::string megabytes(double bytes) { return short_number(bytes / 1e6, 5) + " MB"; }

std::string memory(const std::string& key) {
  std::ifstream file("/proc/meminfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key + ":", 0) == 0) return megabytes(std::stod(line.substr(key.size() + 1)) * 1024);
  }
  return "unknown";
}

std::string group_memory_limit() {
  for (const char* path : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::ifstream file(path);
    double bytes = 0;
    if (file >> bytes && bytes < 1e15) return megabytes(bytes);
  }
  return "none";
}

std::string limit(__rlimit_resource resource, bool bytes) {
  rlimit value{};
  if (::getrlimit(resource, &value) != 0) return "unknown";
  if (value.rlim_cur == RLIM_INFINITY) return "none";
  return bytes ? megabytes(static_cast<double>(value.rlim_cur)) : std::to_string(value.rlim_cur);
}

Facts machine() {
  return {{"compiler", compiler()},
          {"processor", cpu_name()},
          {"processor features", cpu_features()},
          {"usable cores", std::to_string(usable_cores())},
          {"memory", memory("MemTotal")},
          {"memory available", memory("MemAvailable")},
          {"memory limit of the control group", group_memory_limit()},
          {"limit on address space (ulimit -v)", limit(RLIMIT_AS, true)},
          {"limit on file size (ulimit -f)", limit(RLIMIT_FSIZE, true)},
          {"limit on stack (ulimit -s)", limit(RLIMIT_STACK, true)},
          {"limit on processes (ulimit -u)", limit(RLIMIT_NPROC, false)},
          {"limit on open files (ulimit -n)", limit(RLIMIT_NOFILE, false)}};
}

}  // namespace

int doctor(const Arguments& arguments) {
  if (arguments.json) {
    nlohmann::ordered_json out;
    for (const auto& [name, value] : versions()) out["versions"][name] = value;
    for (const auto& [name, value] : machine()) out["machine"][name] = value;
    print(out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    return 0;
  }
  Table table({"what", "value"}, {false, false});
  for (const auto& [name, value] : versions()) table.add({name, value});
  for (const auto& [name, value] : machine()) table.add({name, value});
  print(table.text());
  return 0;
}

}  // namespace afptraj::cli
