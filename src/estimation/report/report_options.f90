!> How CSR-TM-00-01 estimates its own cases: the first guesses of section 6.1. Its weights are the defaults.
module gracecg_estimation_report_options
    use gracecg_base_kinds, only: dp
    use gracecg_base_quaternion, only: normalised
    use gracecg_estimation_options, only: estimation_options_t
    implicit none
    private
    public :: report_options

contains

    !> The options for one of the report's cases; for any other name those that need no telling.
    pure function report_options(name) result(options)
        character(*), intent(in) :: name        !! 'front-1' ... 'back-3'
        type(estimation_options_t) :: options

        real(dp) :: q(4)

        q = 0
        select case (name)
        case ('front-1')
            q = [-0.7_dp, 0.000001_dp, 0.713_dp, 0.000001_dp]
        case ('front-2')
            q = [-0.99_dp, 0.000001_dp, 0.013_dp, 0.000001_dp]
        case ('front-3')
            q = [-0.75_dp, 0.000001_dp, -0.63_dp, 0.000001_dp]      ! printed -0..63
        case ('back-1')
            q = [0.000001_dp, -0.7_dp, 0.000001_dp, 0.713_dp]
        case ('back-2')
            q = [0.000001_dp, -0.99_dp, 0.000001_dp, 0.013_dp]
        case ('back-3')
            q = [0.000001_dp, -0.77_dp, 0.000001_dp, -0.63_dp]
        case default
            return
        end select
        options%guess_quaternion = normalised(q)
        options%guess_angular_velocity = [0.0_dp, merge(0.00122_dp, -0.00122_dp, name(:5) == 'front'), 0.0_dp]
    end function report_options
end module gracecg_estimation_report_options
