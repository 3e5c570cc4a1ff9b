#include "stiction/world/call_coacd.hpp"

#include <dlfcn.h>

#include <atomic>
#include <filesystem>
#include <mutex>

#include "stiction/core/find_upwards.hpp"
#include "stiction/core/invalid_input.hpp"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

namespace stiction::world {

namespace {

// The wheel brings no header. These are the declarations of version 1.0.14, whose Python wrapper names every argument.
struct CoacdMesh {
  double* vertices;
  std::uint64_t vertex_count;
  int* triangles;
  std::uint64_t triangle_count;
};
struct CoacdParts {
  CoacdMesh* meshes;
  std::uint64_t count;
};
using RunFunction = CoacdParts (*)(const CoacdMesh& input, double threshold, int max_parts, int preprocess_mode, int preprocess_resolution,
                                   int resolution, int mcts_nodes, int mcts_iterations, int mcts_depth, bool pca, bool merge, bool decimate,
                                   int max_part_vertices, bool extrude, double extrude_margin, int approximation, unsigned seed,
                                   bool metric_threshold);
using FreeFunction = void (*)(CoacdParts);
using LogLevelFunction = void (*)(const char*);
using SetThreadsFunction = void (*)(int);
using MaxThreadsFunction = int (*)();

std::atomic<std::int64_t> calls = 0;

/// The functions of the library, loaded at the first use. Its symbols stay its own: it exports a whole libstdc++ and an old fmt.
struct Library {
  RunFunction run = nullptr;
  FreeFunction free_parts = nullptr;
  SetThreadsFunction set_threads = nullptr;
  MaxThreadsFunction max_threads = nullptr;
  std::string fault;

  Library() {
    const std::filesystem::path beside = core::find_upwards("coacd/" STICTION_COACD_FILE, core::kInstalledLevels);
    if (!beside.empty() && core::find_upwards("coacd-" STICTION_COACD_VERSION ".dist-info", core::kInstalledLevels).empty()) {
      fault = beside.string() + " is of another version";  // other versions take other arguments
      return;
    }
    void* const handle = dlopen(beside.empty() ? STICTION_COACD_LIBRARY : beside.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) {
      fault = dlerror();
      return;
    }
    run = reinterpret_cast<RunFunction>(dlsym(handle, "CoACD_run"));
    free_parts = reinterpret_cast<FreeFunction>(dlsym(handle, "CoACD_freeMeshArray"));
    const auto set_log_level = reinterpret_cast<LogLevelFunction>(dlsym(handle, "CoACD_setLogLevel"));
    // These functions belong to the OpenMP that comes with the library, which no other library uses.
    set_threads = reinterpret_cast<SetThreadsFunction>(dlsym(handle, "omp_set_num_threads"));
    max_threads = reinterpret_cast<MaxThreadsFunction>(dlsym(handle, "omp_get_max_threads"));
    if (run == nullptr || free_parts == nullptr || set_log_level == nullptr) {
      fault = "functions are missing from it";
      return;
    }
    set_log_level("off");
  }
};

/// Restricts OpenMP to one thread: with several threads, the order of the parts depends on which thread ends first, and merging on that order.
class OneThread {
 public:
  explicit OneThread(const Library& library) : library_(library) {
    if (library.set_threads == nullptr || library.max_threads == nullptr) return;
    before_ = library.max_threads();
    library.set_threads(1);
  }
  ~OneThread() {
    if (before_ > 0) library_.set_threads(before_);
  }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  const Library& library_;
  int before_ = 0;
};

CoacdParts run(const Library& library, const CoacdMesh& input, const Decomposition& options) {
#if defined(__SANITIZE_ADDRESS__)
  const __lsan::ScopedDisabler leaks;  // CoACD_freeMeshArray forgets the array of the meshes
#endif
  constexpr int kPreprocessWhenNeeded = 0, kPreprocessResolution = 50, kSamples = 2000;
  constexpr int kNodes = 20, kIterations = 150, kDepth = 3, kMaxPartVertices = 256, kConvexHulls = 0;
  constexpr unsigned kSeed = 1;
  return library.run(input, options.threshold, options.max_parts, kPreprocessWhenNeeded, kPreprocessResolution, kSamples, kNodes,
                     kIterations, kDepth, /*pca=*/false, /*merge=*/true, /*decimate=*/false, kMaxPartVertices, /*extrude=*/false,
                     /*extrude_margin=*/0.01, kConvexHulls, kSeed, /*metric_threshold=*/false);
}

}  // namespace

std::int64_t coacd_calls() { return calls; }

std::vector<Eigen::Matrix3Xd> call_coacd(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles,
                                         const Decomposition& options) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  static const Library library;
  if (!library.fault.empty())
    core::throw_invalid("convex_decomposition", "no usable CoACD library (" + library.fault + ")",
                        "the one of the Python package coacd " STICTION_COACD_VERSION ": pip install 'stiction[meshes]'");
  ++calls;
  const OneThread one_thread(library);
  Eigen::Matrix3Xd points = vertices;  // the library takes pointers to mutable data
  Eigen::Matrix3Xi indices = triangles;
  const CoacdMesh input{points.data(), static_cast<std::uint64_t>(points.cols()), indices.data(),
                        static_cast<std::uint64_t>(indices.cols())};
  const CoacdParts found = run(library, input, options);
  std::vector<Eigen::Matrix3Xd> parts;
  for (std::uint64_t i = 0; i < found.count; ++i) {
    const CoacdMesh& part = found.meshes[i];
    parts.emplace_back(Eigen::Map<const Eigen::Matrix3Xd>(part.vertices, 3, static_cast<Eigen::Index>(part.vertex_count)));
  }
  library.free_parts(found);
  return parts;
}

}  // namespace stiction::world
