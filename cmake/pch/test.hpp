// Precompiled for the tests.
#include "core.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
