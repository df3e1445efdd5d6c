# What it is built as where nobody says so.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release)
endif()

# NaN is told from numbers, and double length lives on what rounding leaves: such flags end both.
string(TOUPPER "CMAKE_Fortran_FLAGS_${CMAKE_BUILD_TYPE}" build_flags)
if("${CMAKE_Fortran_FLAGS} ${${build_flags}}" MATCHES
        "-Ofast|-ffast-math|-ffinite-math-only|-funsafe-math|-fassociative-math|-ffp-model=(fast|aggressive)")
    message(FATAL_ERROR "gracecg tells NaN from numbers and counts on the order of sums: compile it without ${CMAKE_MATCH_0}")
endif()
