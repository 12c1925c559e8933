// SPDX-License-Identifier: Apache-2.0
#include "house/dependencies.hpp"

#include <algorithm>
#include <set>

namespace cairn::house {
namespace {

struct Include {
  std::string from;    ///< path of the file that includes
  size_t line = 0;     ///< from 1
  std::string name;    ///< as written between the quotes or brackets
  std::string target;  ///< path of the included file in the tree; empty where it is not of it

  std::string place() const { return from + ":" + std::to_string(line); }
};

std::string name_in_include(const std::string& line) {
  size_t at = line.find_first_not_of(" \t");
  if (at == std::string::npos || line[at] != '#') return {};
  at = line.find_first_not_of(" \t", at + 1);
  if (at == std::string::npos || line.compare(at, 7, "include") != 0) return {};
  const size_t open = line.find_first_of("<\"", at);
  if (open == std::string::npos) return {};
  const size_t close = line.find_first_of(">\"", open + 1);
  return close == std::string::npos ? std::string{} : line.substr(open + 1, close - open - 1);
}

std::string target_of(const SourceTree& tree, const std::string& from, const std::string& name) {
  const std::string own = from.substr(0, from.rfind('/') + 1);
  for (const std::string& prefix :
       {own, std::string("lib/"), std::string("procs/"), std::string()}) {
    if (tree.contains(prefix + name)) return prefix + name;
  }
  return {};
}

bool is_lib_or_proc(const std::string& path) {
  return is_cpp(path) && (path.starts_with("lib/") || path.starts_with("procs/"));
}

std::vector<Include> includes_of(const SourceTree& tree) {
  std::vector<Include> includes;
  for (const auto& [path, text] : tree) {
    if (!is_lib_or_proc(path)) continue;
    const std::vector<std::string> lines = lines_of(code_of(text));
    for (size_t i = 0; i < lines.size(); ++i) {
      const std::string name = name_in_include(lines[i]);
      if (!name.empty()) includes.push_back({path, i + 1, name, target_of(tree, path, name)});
    }
  }
  return includes;
}

bool is_generated_message(const std::string& name) {
  return name.starts_with("cairn/") && name.ends_with("_t.hpp");
}

std::string complaint_about(const Include& include) {
  const std::string from = folder_of(include.from);
  const std::string to = folder_of(include.target);
  const bool is_lib = from.starts_with("lib/");
  const bool is_science = is_lib && from != "lib/bus" && from != "lib/messages";
  if (include.name.starts_with("lcm/") && from != "lib/bus") return "only lib/bus includes LCM";
  if (is_science && is_generated_message(include.name)) return "science knows no messages";
  if (is_science && (to == "lib/bus" || to == "lib/messages")) return "science knows no bus";
  if (is_lib && to.starts_with("procs/")) return "a library knows no process";
  return {};
}

/// Extends `path` along the graph until it meets itself; true when it did.
bool walk_into_cycle(const DependencyGraph& graph, std::vector<std::string>& path,
                     std::set<std::string>& finished) {
  for (const auto& [next, because] : graph.at(path.back())) {
    if (finished.contains(next)) continue;
    const auto met = std::find(path.begin(), path.end(), next);
    const bool closes = met != path.end();
    if (closes) path.erase(path.begin(), met);
    path.push_back(next);
    if (closes || walk_into_cycle(graph, path, finished)) return true;
  }
  finished.insert(path.back());
  path.pop_back();
  return false;
}

}  // namespace

DependencyGraph dependency_graph(const SourceTree& tree) {
  DependencyGraph graph;
  for (const auto& [path, text] : tree) {
    if (is_lib_or_proc(path) && !folder_of(path).empty()) graph[folder_of(path)];
  }
  for (const Include& include : includes_of(tree)) {
    const std::string from = folder_of(include.from);
    const std::string to = folder_of(include.target);
    if (!to.empty() && to != from) graph[from].try_emplace(to, include.place());
  }
  return graph;
}

std::vector<std::string> dependency_order(const DependencyGraph& graph) {
  std::vector<std::string> order;
  std::set<std::string> placed;
  const auto is_ready = [&](const auto& folder) {
    return !placed.contains(folder.first) &&
           std::all_of(folder.second.begin(), folder.second.end(),
                       [&](const auto& needed) { return placed.contains(needed.first); });
  };
  for (auto next = std::find_if(graph.begin(), graph.end(), is_ready); next != graph.end();
       next = std::find_if(graph.begin(), graph.end(), is_ready)) {
    placed.insert(next->first);
    order.push_back(next->first);
  }
  return order;
}

Findings cycle_in(const DependencyGraph& graph) {
  std::set<std::string> finished;
  for (const auto& [folder, needed] : graph) {
    std::vector<std::string> path{folder};
    if (finished.contains(folder) || !walk_into_cycle(graph, path, finished)) continue;
    Findings steps;
    for (size_t i = 0; i + 1 < path.size(); ++i) {
      steps.push_back(graph.at(path[i]).at(path[i + 1]) + ": a cycle: " + path[i] + " includes " +
                      path[i + 1]);
    }
    return steps;
  }
  return {};
}

Findings forbidden_includes(const SourceTree& tree) {
  Findings findings;
  for (const Include& include : includes_of(tree)) {
    const std::string complaint = complaint_about(include);
    if (complaint.empty()) continue;
    findings.push_back(include.place() + ": " + include.name + ": " + complaint);
  }
  return findings;
}

}  // namespace cairn::house
