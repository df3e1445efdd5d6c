!> The CG offset from the accelerometer along a known rotation: the second part of ASSEST,
!> CSR-TM-00-01 eqs. (4-80)-(4-82). Linear in its state [d, alpha, beta].
module gracecg_estimation_offset_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_attitude_fit, only: fitted_rotation_t
    use gracecg_estimation_batch_problem, only: batch_problem_t
    use gracecg_estimation_iteration, only: iteration_t, rms_of
    use gracecg_estimation_offset_model, only: offset_matrix
    implicit none
    private
    public :: offset_problem_t, prepare_offset, linearise_accelerations
    public :: OFFSET_PARAMETERS, OFFSET_NAMES, ACCELEROMETER_AXES, offset_scales

    !> Number of the parameters of the state [d, alpha, beta]
    integer, parameter :: OFFSET_PARAMETERS = 9
    !> Their names, for messages
    character(12), parameter :: OFFSET_NAMES(OFFSET_PARAMETERS) = [character(12) :: &
        'd_x', 'd_y', 'd_z', 'alpha_x', 'alpha_y', 'alpha_z', 'beta_x', 'beta_y', 'beta_z']

    !> Whose residuals, in the history of a fit
    character(12), parameter :: ACCELEROMETER_AXES(3) = [character(12) :: 'acc_x', 'acc_y', 'acc_z']

    !> Offset, drift and bias from the accelerometer along a known rotation: the second part of ASSEST.
    type, extends(batch_problem_t) :: offset_problem_t
        type(fitting_data_t) :: data                !! The observations, preprocessed
        type(fitted_rotation_t) :: rotation         !! The known rotation
        real(dp) :: state(OFFSET_PARAMETERS) = 0    !! d (m), alpha (m/s^3), beta (m/s^2)
        real(dp) :: weight(3) = 1                   !! Of the accelerometer axes
    contains
        procedure :: linearise => linearise_offset
        procedure :: correct => correct_offset
        procedure :: describe_residuals => residuals_of_offset
        procedure :: describe_state => state_of_offset
    end type offset_problem_t

contains

    !> Sets up the problem from preprocessed observations and the fitted rotation.
    subroutine prepare_offset(knowledge, options, data, rotation, problem)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(fitting_data_t), intent(in) :: data
        type(fitted_rotation_t), intent(in) :: rotation
        type(offset_problem_t), intent(inout) :: problem

        problem%data = data
        problem%rotation = rotation
        problem%names = OFFSET_NAMES
        problem%scales = offset_scales(knowledge%duration)
        problem%observations = 3*size(data%accelerometer_epoch)
        problem%linear = .true.
        problem%state = 0
        problem%state(1:3) = options%guess_offset
        problem%weight = options%accelerometer_weight
    end subroutine prepare_offset

    !> Typical sizes of d, alpha and beta.
    pure function offset_scales(duration) result(scales)
        real(dp), intent(in) :: duration        !! Of the arc, s
        real(dp) :: scales(OFFSET_PARAMETERS)

        real(dp), parameter :: TYPICAL_OFFSET = 1e-3_dp         ! m
        real(dp), parameter :: TYPICAL_ACCELERATION = 1e-6_dp   ! m/s^2

        scales(1:3) = TYPICAL_OFFSET
        scales(4:6) = TYPICAL_ACCELERATION/duration
        scales(7:9) = TYPICAL_ACCELERATION
    end function offset_scales

    !> Partials [A~, t I, I] of (4-22)-(4-24), (4-82) and residuals of the accelerometer, (4-18), (4-81).
    pure subroutine linearise_accelerations(data, rotation, state, partials, residuals)
        type(fitting_data_t), intent(in) :: data
        type(fitted_rotation_t), intent(in) :: rotation
        real(dp), intent(in) :: state(OFFSET_PARAMETERS)    !! Nominal d, alpha, beta
        real(dp), intent(out) :: partials(:, :)             !! 9 x (3 times samples)
        real(dp), intent(out) :: residuals(:)               !! m/s^2

        real(dp) :: t, a(3, 3)
        integer :: i, k, row, axis

        partials = 0
        do i = 1, size(data%accelerometer_epoch)
            k = data%accelerometer_epoch(i)
            t = k*data%interval
            row = 3*(i - 1)
            a = offset_matrix(rotation%omega(:, k), rotation%omega_dot(:, k))
            partials(1:3, row + 1:row + 3) = transpose(a)
            do axis = 1, 3
                partials(3 + axis, row + axis) = t
                partials(6 + axis, row + axis) = 1
            end do
            residuals(row + 1:row + 3) = data%acceleration(:, i) - &
                                         matmul(a, state(1:3)) - state(4:6)*t - state(7:9)
        end do
    end subroutine linearise_accelerations

    subroutine linearise_offset(self, partials, residuals, weights, error)
        class(offset_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :)
        real(dp), intent(out) :: residuals(:), weights(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        call linearise_accelerations(self%data, self%rotation, self%state, partials, residuals)
        do axis = 1, 3
            weights(axis::3) = self%weight(axis)
        end do
    end subroutine linearise_offset

    subroutine correct_offset(self, correction)
        class(offset_problem_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)

        self%state = self%state + correction
    end subroutine correct_offset

    !> RMS of the residuals of the accelerometer's axes.
    subroutine residuals_of_offset(self, residuals, note)
        class(offset_problem_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)        !! x, y, z of each sample in turn, m/s^2
        type(iteration_t), intent(inout) :: note

        integer :: i

        note%residual_names = ACCELEROMETER_AXES
        note%residual_rms = [(rms_of(residuals(i::3)), i=1, 3)]
        note%residual_unit = 'm/s^2'
    end subroutine residuals_of_offset

    subroutine state_of_offset(self, note)
        class(offset_problem_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        note%state_names = OFFSET_NAMES
        note%state = self%state
    end subroutine state_of_offset
end module gracecg_estimation_offset_problem
