!> What modules of Level-1 are written with: `use` of this module in place of a list of a dozen. It has nothing of its own.
module gracecg_level1_basics
    use gracecg_base_constants, only: AXES, DEGREE, MICROMETRE, MILLIMETRE, NANOTESLA, SECONDS_PER_DAY, TWO_PI
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_quaternion, only: normalised, quaternion_product, rotation_between, rotation_matrix
    use gracecg_base_statistics, only: median_of
    use gracecg_base_text, only: string_t, append, integer_text, lower_case, parse_integer, parse_real, pick_text, real_text, &
        rounded_text, split_words
    use gracecg_base_vectors, only: cross, inverse_3x3
    use gracecg_environment_time, only: utc_t, utc_of_gps, utc_plus
    implicit none
    private
    public :: AXES, DEGREE, MICROMETRE, MILLIMETRE, NANOTESLA, SECONDS_PER_DAY, TWO_PI, error_t, fail, add_context, &
        last_not_after, dp, i8, normal_equations, solve_normal_equations, normalised, quaternion_product, rotation_between, &
        rotation_matrix, median_of, string_t, append, integer_text, lower_case, parse_integer, parse_real, pick_text, real_text, &
        rounded_text, split_words, cross, inverse_3x3, utc_t, utc_of_gps, utc_plus
end module gracecg_level1_basics
