!> Is an estimate one that a satellite can have?
module gracecg_estimation_plausibility
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_estimation_solution, only: solution_t
    implicit none
    private
    public :: refuse_implausible

    real(dp), parameter :: SIGMAS = 5       !! Of an estimate that may still belong to a plausible offset

contains

    !> Mass and accelerometer of such a satellite are balanced to a millimetre: an offset beyond a centimetre
    !> tells of wrong units, axes or times, unless the noise alone can make it. To be asked of one's own
    !> observations: a study of a weak manoeuvre may well find such offsets.
    subroutine refuse_implausible(solution, largest, error)
        type(solution_t), intent(in) :: solution
        real(dp), intent(in) :: largest         !! Of each component, m: largest_offset of the options
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: beyond(3)                   ! m
        integer :: axis

        if (.not. solution%converged) return
        beyond = [(abs(solution%offset(axis)) - SIGMAS*sqrt(solution%covariance(axis, axis)), axis=1, 3)]
        axis = maxloc(beyond, 1)
        if (beyond(axis) <= largest) return
        call fail(error, solution%algorithm//': the CG offset on '//AXES(axis)//' would be '// &
                  number_text(solution%offset(axis)/MILLIMETRE)//' mm; beyond '//number_text(largest/MILLIMETRE)// &
                  ' mm it is not plausible: check units, axes and time tags of the samples and the rods of the setup, or '// &
                  'raise largest_offset_mm of the group estimation of the options')
    end subroutine refuse_implausible
end module gracecg_estimation_plausibility
