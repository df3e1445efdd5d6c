!> What an estimator did on its way: each iteration with its corrections, the state after it, and the
!> residuals before it, as the batch processor of CSR-TM-00-01 Figure 4.1 prints them.
module gracecg_estimation_iteration
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: iteration_t, append_iteration, rms_of

    !> One solution of the normal equations.
    type :: iteration_t
        character(32) :: fit = ''                       !! What is fitted
        integer :: number = 0                           !! Of the iteration within this fit, from 1
        character(12), allocatable :: names(:)          !! Of the corrections
        real(dp), allocatable :: correction(:)          !! SI units, by `names`
        character(12), allocatable :: state_names(:)    !! Of the state: q1 to q4, omega, d, alpha, beta
        real(dp), allocatable :: state(:)               !! After the correction, SI units, by `state_names`
        character(12), allocatable :: residual_names(:) !! Whose residuals
        real(dp), allocatable :: residual_rms(:)        !! Before the correction, in `residual_unit`
        character(12) :: residual_unit = '1'            !! SI, or sigma: in standard deviations of the noise
    end type iteration_t

contains

    !> Puts one more at the end, numbered within its fit.
    subroutine append_iteration(history, iteration, fit)
        type(iteration_t), allocatable, intent(inout) :: history(:)
        type(iteration_t), intent(in) :: iteration
        character(*), intent(in) :: fit             !! What is fitted

        type(iteration_t), allocatable :: longer(:)
        integer :: n

        if (.not. allocated(history)) allocate (history(0))
        n = size(history)
        allocate (longer(n + 1))
        longer(:n) = history
        longer(n + 1) = iteration
        longer(n + 1)%fit = fit
        longer(n + 1)%number = 1
        if (n > 0) then
            if (history(n)%fit == fit) longer(n + 1)%number = history(n)%number + 1
        end if
        call move_alloc(longer, history)
    end subroutine append_iteration

    !> Root of the mean square; 0 of none.
    pure real(dp) function rms_of(values)
        real(dp), intent(in) :: values(:)       !! In any unit

        rms_of = norm2(values)/sqrt(real(max(1, size(values)), dp))
    end function rms_of
end module gracecg_estimation_iteration
