!> What a manoeuvre may do to the attitude of a satellite.
module gracecg_spacecraft_motion_limits
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    implicit none
    private
    public :: motion_limits_t

    !> Limits of the rotation during a manoeuvre.
    type :: motion_limits_t
        real(dp) :: rate = 0.1_dp*DEGREE
        !! Greatest angular velocity about any axis, rad/s: what the star cameras bear, CSR-TM-00-01 4.1
        real(dp) :: pointing = DEGREE
        !! Greatest turn away from the attitude that is held without a manoeuvre, rad
    end type motion_limits_t
end module gracecg_spacecraft_motion_limits
