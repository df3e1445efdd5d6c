!> What is usual of the torque rods of GRACE where nothing is said: moment by current, and how much a current disturbs the
!> accelerometer beside it.
module gracecg_spacecraft_rod_leakage
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: USUAL_ROD_GAIN, USUAL_LEAKAGE

    real(dp), parameter :: USUAL_ROD_GAIN = 0.25_dp     !! A m^2/mA
    !> Standard deviations of the acceleration in proportion to a rod's current, m/s^2/mA, and to its rate, m/s^2/(mA/s)
    real(dp), parameter :: USUAL_LEAKAGE(2) = [1e-12_dp, 3e-11_dp]
end module gracecg_spacecraft_rod_leakage
