// with_opencv(): OpenCV's lack of memory becomes everybody's.
#pragma once

#include <new>
#include <opencv2/core.hpp>

namespace scanknit {

/// Does `work`. OpenCV says by an exception of its own that memory is short: it becomes std::bad_alloc.
template <typename Work>
auto with_opencv(const Work& work) {
  try {
    return work();
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    throw;
  }
}

}  // namespace scanknit
