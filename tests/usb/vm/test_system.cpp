// What only a real system has
#include <gtest/gtest.h>
