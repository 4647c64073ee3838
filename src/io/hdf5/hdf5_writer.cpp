// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5/hdf5_writer.h"

#include "ovoid/error.h"

#ifdef OVOID_IO_HDF5
#include <dlfcn.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "data/out_of_memory.h"
#endif

namespace ovoid::io {

#ifdef OVOID_IO_HDF5
namespace {

// Every function of the library that is called here, without its H5.
// clang-format off
#define OVOID_HDF5_FUNCTIONS(DO)                                                                   \
  DO(open) DO(Aclose) DO(Acreate2) DO(Awrite) DO(Dclose) DO(Dcreate2) DO(Dget_space) DO(Dwrite)    \
  DO(Eget_auto2) DO(Eset_auto2) DO(Fclose) DO(Fcreate) DO(Fflush) DO(Gclose) DO(Gcreate2)          \
  DO(Pclose) DO(Pcreate) DO(Pset_chunk) DO(Pset_deflate) DO(Pset_fill_time)                        \
  DO(Pset_libver_bounds) DO(Pset_obj_track_times) DO(Pset_shuffle) DO(Sclose) DO(Screate)          \
  DO(Screate_simple) DO(Sget_simple_extent_dims) DO(Sget_simple_extent_ndims)                      \
  DO(Sselect_hyperslab) DO(Tclose) DO(Tcopy) DO(Tset_cset) DO(Tset_size) DO(Tset_strpad)
// clang-format on

void require_room(std::size_t num_bytes) {
  // Not malloc(): what is freed unused need never have been there, to a compiler.
  void* const tried =
      ::mmap(nullptr, num_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (tried == MAP_FAILED) data::throw_out_of_memory("the HDF5 library", num_bytes);
  ::munmap(tried, num_bytes);
}

// The library's functions, and what its header would take from its variables.
struct Library {
// NOLINTNEXTLINE(bugprone-macro-parentheses): GCC warns of them
#define OVOID_DECLARE(name) decltype(&::H5##name) name = nullptr;
  OVOID_HDF5_FUNCTIONS(OVOID_DECLARE)
#undef OVOID_DECLARE

  Library() {
    // Twice what it and the libraries that it brings are mapped to.
    require_room(std::size_t{40} << 20);
    handle_ = ::dlopen(OVOID_HDF5_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr)
      throw Error(
          ErrorCode::kUnsupported,
          fmt::format("cannot write HDF5: {}: install HDF5's library of this name", ::dlerror()));
#define OVOID_FIND(name) find("H5" #name, name);
    OVOID_HDF5_FUNCTIONS(OVOID_FIND)
#undef OVOID_FIND
    if (open() < 0)
      throw Error(ErrorCode::kUnsupported,
                  "cannot write HDF5: " OVOID_HDF5_LIBRARY " does not start");
  }

  // A variable's value: `P_CLS_FILE_ACCESS_ID` of H5P_CLS_FILE_ACCESS_ID_g. A program that was
  // linked with the library may have drawn the variable into itself; the library's own then keeps
  // its first value, which names nothing.
  hid_t id(const char* name) const {
    const std::string variable = fmt::format("H5{}_g", name);
    const hid_t* place = nullptr;
    find(variable.c_str(), place);
    const auto* const drawn = static_cast<const hid_t*>(::dlsym(RTLD_DEFAULT, variable.c_str()));
    return *place > 0 || drawn == nullptr ? *place : *drawn;
  }

  hid_t native(ScalarType type) const {
    constexpr std::array kNames = {
        std::pair{ScalarType::kUInt8, "UINT8"},   std::pair{ScalarType::kInt8, "INT8"},
        std::pair{ScalarType::kUInt16, "UINT16"}, std::pair{ScalarType::kInt16, "INT16"},
        std::pair{ScalarType::kUInt32, "UINT32"}, std::pair{ScalarType::kInt32, "INT32"},
        std::pair{ScalarType::kUInt64, "UINT64"}, std::pair{ScalarType::kInt64, "INT64"},
        std::pair{ScalarType::kFloat32, "FLOAT"}, std::pair{ScalarType::kFloat64, "DOUBLE"},
    };
    const auto* const named = std::ranges::find(kNames, type, [](auto pair) { return pair.first; });
    return id(fmt::format("T_NATIVE_{}", named->second).c_str());
  }

 private:
  template <typename T>
  void find(const char* name, T*& place) const {
    place = reinterpret_cast<T*>(::dlsym(handle_, name));
    if (place == nullptr)
      throw Error(ErrorCode::kUnsupported, fmt::format("cannot write HDF5: {}", ::dlerror()));
  }

  void* handle_ = nullptr;
};

// Loaded by the first call that succeeds, and never let go: the library keeps threads' data.
const Library& library() {
  static const Library loaded;
  return loaded;
}

// An identifier of the library, given back when it goes.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Handle(hid_t id, Close by) : id_(id), close_(by) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  hid_t get() const noexcept { return id_; }

 private:
  hid_t id_;
  Close close_;
};

// While this lives no other thread calls the library, and it prints nothing.
class Call {
 public:
  Call() : lock_(mutex()) {
    h5.Eget_auto2(H5E_DEFAULT, &function_, &data_);
    h5.Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Call() { h5.Eset_auto2(H5E_DEFAULT, function_, data_); }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  const Library& h5 = library();

  // A property list of class `name`; of what is made by it, no time is kept.
  Handle properties(const char* name) const {
    const hid_t list = h5.Pcreate(h5.id(fmt::format("P_CLS_{}_ID", name).c_str()));
    h5.Pset_obj_track_times(list, 0);
    return {list, h5.Pclose};
  }

  Handle space(const std::vector<std::uint64_t>& dims) const {
    const std::vector<hsize_t> sizes(dims.begin(), dims.end());
    return {sizes.empty()
                ? h5.Screate(H5S_SCALAR)
                : h5.Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr),
            h5.Sclose};
  }

  bool add_attribute(hid_t object, const char* name, hid_t type, hid_t space,
                     const void* values) const {
    const Handle made(h5.Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), h5.Aclose);
    return made.get() >= 0 && h5.Awrite(made.get(), type, values) >= 0;
  }

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }

  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

}  // namespace

bool Hdf5Object::close() noexcept {
  if (!is_open()) return true;
  const hid_t id = std::exchange(id_, -1);
  const Call call;
  switch (kind_) {
    case Kind::kFile:
      return call.h5.Fclose(id) >= 0;
    case Kind::kGroup:
      return call.h5.Gclose(id) >= 0;
    case Kind::kDataset:
      break;
  }
  return call.h5.Dclose(id) >= 0;
}

Hdf5Object Hdf5Object::make_group(const std::string& name) const {
  const Call call;
  const Handle plist = call.properties("GROUP_CREATE");
  return {call.h5.Gcreate2(id_, name.c_str(), H5P_DEFAULT, plist.get(), H5P_DEFAULT), Kind::kGroup};
}

Hdf5Object Hdf5Object::make_dataset(const std::string& name, ScalarType type,
                                    const std::vector<std::uint64_t>& dims,
                                    const std::vector<std::uint64_t>& chunk) const {
  const Call call;
  const auto& h5 = call.h5;
  const std::vector<hsize_t> sizes(chunk.begin(), chunk.end());
  const Handle plist = call.properties("DATASET_CREATE");
  if (h5.Pset_chunk(plist.get(), static_cast<int>(sizes.size()), sizes.data()) < 0 ||
      h5.Pset_shuffle(plist.get()) < 0 || h5.Pset_deflate(plist.get(), kDeflateLevel) < 0 ||
      h5.Pset_fill_time(plist.get(), H5D_FILL_TIME_NEVER) < 0)
    return {};
  return {h5.Dcreate2(id_, name.c_str(), h5.native(type), call.space(dims).get(), H5P_DEFAULT,
                      plist.get(), H5P_DEFAULT),
          Kind::kDataset};
}

bool Hdf5Object::write_rows(std::uint64_t first, std::uint64_t count, ScalarType type,
                            const void* values) const {
  const Call call;
  const auto& h5 = call.h5;
  const Handle file(h5.Dget_space(id_), h5.Sclose);
  const int rank = h5.Sget_simple_extent_ndims(file.get());
  if (rank < 1) return false;
  std::vector<hsize_t> start(static_cast<std::size_t>(rank), 0), size = start;
  h5.Sget_simple_extent_dims(file.get(), size.data(), nullptr);
  start[0] = first;
  size[0] = count;
  const Handle memory(h5.Screate_simple(rank, size.data(), nullptr), h5.Sclose);
  return h5.Sselect_hyperslab(file.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(),
                              nullptr) >= 0 &&
         h5.Dwrite(id_, h5.native(type), memory.get(), file.get(), H5P_DEFAULT, values) >= 0;
}

bool Hdf5Object::add_text(const char* name, const std::string& text) const {
  const Call call;
  const auto& h5 = call.h5;
  const Handle type(h5.Tcopy(h5.id("T_C_S1")), h5.Tclose);
  return h5.Tset_size(type.get(), std::max<std::size_t>(text.size(), 1)) >= 0 &&
         h5.Tset_strpad(type.get(), H5T_STR_NULLPAD) >= 0 &&
         h5.Tset_cset(type.get(), H5T_CSET_UTF8) >= 0 &&
         call.add_attribute(id_, name, type.get(), call.space({}).get(), text.c_str());
}

bool Hdf5Object::add_numbers(const char* name, ScalarType type, const void* values,
                             const std::vector<std::uint64_t>& dims) const {
  const Call call;
  return call.add_attribute(id_, name, call.h5.native(type), call.space(dims).get(), values);
}

bool Hdf5Object::flush() const {
  const Call call;
  return call.h5.Fflush(id_, H5F_SCOPE_GLOBAL) >= 0;
}

void require_hdf5(std::size_t chunk_bytes) {
  library();
  // For the library itself some MiB, and with its filters three times a chunk.
  require_room((std::size_t{16} << 20) + 3 * chunk_bytes);
}

Hdf5Object make_hdf5_file(const std::string& path) {
  const Call call;
  const auto& h5 = call.h5;
  const Handle plist = call.properties("FILE_CREATE");
  // The file format of HDF5 1.10, whose descriptions of things carry checksums: damage is told
  // before the library believes it.
  const Handle access(h5.Pcreate(h5.id("P_CLS_FILE_ACCESS_ID")), h5.Pclose);
  if (h5.Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_LATEST) < 0) return {};
  constexpr unsigned kTruncate = 2;  // H5F_ACC_TRUNC, which calls the library by name
  return {h5.Fcreate(path.c_str(), kTruncate, plist.get(), access.get()), Hdf5Object::Kind::kFile};
}

#else

bool Hdf5Object::close() noexcept { return true; }
Hdf5Object Hdf5Object::make_group(const std::string&) const { return {}; }
Hdf5Object Hdf5Object::make_dataset(const std::string&, ScalarType,
                                    const std::vector<std::uint64_t>&,
                                    const std::vector<std::uint64_t>&) const {
  return {};
}
bool Hdf5Object::write_rows(std::uint64_t, std::uint64_t, ScalarType, const void*) const {
  return false;
}
bool Hdf5Object::add_text(const char*, const std::string&) const { return false; }
bool Hdf5Object::add_numbers(const char*, ScalarType, const void*,
                             const std::vector<std::uint64_t>&) const {
  return false;
}
bool Hdf5Object::flush() const { return false; }

void require_hdf5(std::size_t) {
  throw Error(ErrorCode::kUnsupported, "this build cannot write HDF5");
}

Hdf5Object make_hdf5_file(const std::string&) {
  require_hdf5(0);
  return {};
}

#endif

}  // namespace ovoid::io
