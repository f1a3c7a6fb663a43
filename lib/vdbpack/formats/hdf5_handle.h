// Private: objects of the HDF5 library.
#pragma once

#include <hdf5.h>

#include <utility>

namespace vdbpack {

/// An open object of HDF5, which is closed at the end of the scope; invalid if it was not there.
class Hdf5 {
public:
    using Close = herr_t (*)(hid_t);

    Hdf5(hid_t id, Close close) : id_(id), close_(close) {}
    Hdf5(Hdf5&& other) noexcept
        : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
    Hdf5(const Hdf5&) = delete;
    Hdf5& operator=(const Hdf5&) = delete;
    ~Hdf5() {
        if (id_ >= 0) close_(id_);
    }

    operator hid_t() const { return id_; }
    bool isValid() const { return id_ >= 0; }

private:
    hid_t id_;
    Close close_;
};

/// Keeps the library from printing its errors while it is used.
class Hdf5Quiet {
public:
    Hdf5Quiet() {
        H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    Hdf5Quiet(const Hdf5Quiet&) = delete;
    Hdf5Quiet& operator=(const Hdf5Quiet&) = delete;
    ~Hdf5Quiet() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }

private:
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

}  // namespace vdbpack
