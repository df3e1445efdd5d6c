!> An arc in a fit of several (gracecg_estimation_arcs): its whitened problem, with a sample of the accelerometer at every epoch,
!> and what it says of the parameters that all arcs share.
module gracecg_estimation_arc_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_autoregression, only: autoregression_t, autocovariances_t, predictors_of
    use gracecg_base_coloured_noise, only: noise_spectrum_t
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: grouped_normal_equations
    use gracecg_base_statistics, only: median_of
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters, only: KIND_OF, OF_ALL_RODS_DELAY
    use gracecg_estimation_information, only: information_t, eliminated_t, no_information
    use gracecg_estimation_iteration, only: rms_of
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_noise_whitening, only: autoregressive_whitener
    use gracecg_estimation_outlier_editing, only: leave_out_worst, MEDIAN_OF_ONE, MEDIAN_OF_THREE
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, prepare_calibration, set_noise
    implicit none
    private
    public :: arc_t, prepare_arc, take_noise, find_disturbed, reduce_arc, refresh_and_edit, covariance_of, LEAST_ANGLE

    real(dp), parameter :: LIMIT = 6                !! Of editing, standard deviations
    real(dp), parameter :: FIRST_LEVEL = 2e-9_dp, FIRST_ANGULAR = 1e-7_dp, FIRST_ANGLE = 1e-6_dp
    !! Standard deviations to begin with, m/s^2, rad/s^2, rad
    real(dp), parameter :: LEAST_ANGLE = 1e-8_dp    !! Standard deviation of a star camera, rad: samples without noise weigh
    !! no more

    !> An arc in the fit.
    type :: arc_t
        type(whitened_problem_t) :: problem         !! Of its samples, with the parameters shared and its own
        integer, allocatable :: own(:)              !! Its own parameters, places among all
        logical :: held = .false.                   !! The moments of the rods are
        real(dp) :: excess(6) = 1                   !! Of the noise of the accelerometer's axes and channels over that of all arcs
        type(information_t) :: information          !! About corrections of the shared parameters
        type(eliminated_t) :: eliminated            !! Corrections of its own
    end type arc_t

contains

    !> The problem of an arc; at the state where it was, if it had been there before.
    subroutine prepare_arc(set, options, shared, own, arc, error)
        type(observation_set_t), intent(in) :: set
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: shared(:), own(:)    !! Places of the parameters of all arcs, and of this one's own
        type(arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        type(whitened_problem_t) :: before
        type(fitting_data_t) :: data
        logical, allocatable :: there(:)
        logical :: again
        integer :: axis

        again = allocated(arc%own)
        if (again) before = arc%problem
        call preprocess(set, options, data, error)
        if (allocated(error)) return
        call take_all_epochs(data, there)
        call prepare_calibration(set%knowledge, options, data, [shared, own], arc%problem)
        call arc%problem%forget_prior(size(shared))
        arc%own = own
        arc%held = set%knowledge%rods%measured%held
        arc%problem%acceleration_kept = spread(there, 1, 3)
        associate (noise => arc%problem%noise, at => arc%problem)
            noise%star_camera_sigma = FIRST_ANGLE
            noise%second_head_sigma = [1.0_dp, FIRST_ANGLE, 1.0_dp]
            do axis = 1, 3
                noise%accelerometer(axis) = noise_spectrum_t(2*at%model%interval*FIRST_LEVEL**2, 0.0_dp, &
                                                             noise%accelerometer(axis)%sides)
            end do
            if (.not. again) then
                call set_noise(at, error)
                call take_noise(arc, white(FIRST_LEVEL, 3), white(FIRST_ANGULAR, 3))
                return
            end if
            at%state = before%state
            at%noise = before%noise
            at%star_kept = before%star_kept
            at%acceleration_kept = before%acceleration_kept
        end associate
    end subroutine prepare_arc

    !> Gives data of the accelerometer a sample at every epoch.
    pure subroutine take_all_epochs(data, there)
        type(fitting_data_t), intent(inout) :: data
        logical, allocatable, intent(out) :: there(:)       !! Which are samples; the others stand for none

        real(dp) :: all(3, data%steps + 1)
        integer :: k

        there = [(.false., k=0, data%steps)]
        there(data%accelerometer_epoch + 1) = .true.
        all = 0
        all(:, data%accelerometer_epoch + 1) = data%acceleration
        data%acceleration = all
        if (size(data%angular) > 0) then
            all(:, data%accelerometer_epoch + 1) = data%angular
            data%angular = all
        end if
        data%accelerometer_epoch = [(k, k=0, data%steps)]
    end subroutine take_all_epochs

    !> White noise.
    pure function white(deviation, axes) result(models)
        real(dp), intent(in) :: deviation
        integer, intent(in) :: axes
        type(autoregression_t) :: models(axes)

        type(autocovariances_t) :: sums
        integer :: axis

        call sums%begin(1)
        sums%sums(0) = deviation**2
        do axis = 1, axes
            models(axis) = predictors_of(sums, 1.0_dp)
        end do
    end function white

    !> Whiteners of an arc for the noise of the axes.
    subroutine take_noise(arc, linear, angular)
        type(arc_t), intent(inout) :: arc
        type(autoregression_t), intent(in) :: linear(3), angular(3)     !! That of all arcs

        integer :: axis

        do axis = 1, 3
            associate (problem => arc%problem, kept => arc%problem%acceleration_kept(axis, :))
                call autoregressive_whitener(risen(linear(axis), arc%excess(axis)), kept, problem%whiteners(axis))
                if (problem%channel_rows > 0) call autoregressive_whitener(risen(angular(axis), arc%excess(3 + axis)), kept, &
                                                                           problem%channel_whiteners(axis))
            end associate
        end do
    end subroutine take_noise

    !> Noise of the same spectrum, so many times larger.
    pure function risen(model, times) result(larger)
        type(autoregression_t), intent(in) :: model
        real(dp), intent(in) :: times
        type(autoregression_t) :: larger

        larger = model
        larger%deviation = times*model%deviation
    end function risen

    !> Which arcs are disturbed: their noise is so much larger than that of most that they would take weight from the others. They
    !> count by their own.
    pure subroutine find_disturbed(arcs)
        type(arc_t), intent(inout) :: arcs(:)

        integer, parameter :: FEWEST = 20               ! Arcs: of fewer most may be disturbed
        real(dp), parameter :: MUCH = 1.5_dp            ! Of a sound day's arcs none of thousands is beyond 1.3
        real(dp) :: noise(6, size(arcs))
        integer :: i, axis

        if (size(arcs) < FEWEST) return
        noise = 0
        do i = 1, size(arcs)
            associate (p => arcs(i)%problem, kept => arcs(i)%problem%acceleration_kept)
                do axis = 1, 3
                    noise(axis, i) = rms_of(pack(p%whiteners(axis)%innovations(p%acceleration_residual(axis, :)), kept(axis, :)))
                    if (p%channel_rows > 0) noise(3 + axis, i) = &
                        rms_of(pack(p%channel_whiteners(axis)%innovations(p%channel_residual(axis, :)), kept(axis, :)))
                end do
                noise(:, i) = arcs(i)%excess*noise(:, i)
            end associate
        end do
        do axis = 1, 6
            noise(axis, :) = noise(axis, :)/max(median_of(noise(axis, :)), tiny(1.0_dp))
        end do
        do i = 1, size(arcs)
            arcs(i)%excess = merge(noise(:, i), 1.0_dp, noise(:, i) > MUCH)
        end do
    end subroutine find_disturbed

    !> The normal equations of an arc without its own parameters. Samples of the accelerometer between the steps of held moments
    !> are the same with another delay of the rods: that is told by the attitude.
    subroutine reduce_arc(arc, n, error, channels)
        type(arc_t), intent(inout) :: arc
        integer, intent(in) :: n                    !! Number of shared parameters
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: channels   !! The angular channels count; absent: they do

        real(dp), allocatable :: partials(:, :), residuals(:), weights(:)
        integer :: all, k

        associate (problem => arc%problem)
            all = n + size(arc%own)
            allocate (partials(all, problem%observations), residuals(problem%observations), weights(problem%observations))
            call problem%linearise(partials, residuals, weights, error)
            if (allocated(error)) return
            if (present(channels)) then
                if (.not. channels) partials(:, problem%star_rows + problem%acceleration_rows + 1:problem%sample_rows()) = 0
            end if
            if (arc%held) then
                do k = 1, all
                    if (KIND_OF(problem%model%estimated(k)) == OF_ALL_RODS_DELAY) &
                        partials(k, problem%star_rows + 1:problem%sample_rows()) = 0
                end do
            end if
            arc%information = no_information(all)
            call grouped_normal_equations(problem%groups, partials, residuals, arc%information%matrix, arc%information%rhs)
            arc%information%squares = sum(residuals**2)
            do k = n + 1, merge(all, n, present(channels))      ! what only those tell that are left out
                if (.not. arc%information%matrix(k, k) > 0) call arc%information%expect(k, 1.0_dp)
            end do
            call arc%information%eliminate(n, arc%eliminated, error, problem%names(n + 1:))
        end associate
    end subroutine reduce_arc

    !> Residuals at the state, and what does not belong to the fit left out.
    subroutine refresh_and_edit(problem, changed)
        type(whitened_problem_t), intent(inout) :: problem
        logical, intent(inout) :: changed           !! Set if another sample is left out

        real(dp) :: residuals(problem%observations), normalised(size(problem%star_kept))
        logical :: kept(size(problem%acceleration_kept, 2))
        integer :: axis, i

        call problem%compare(residuals)
        kept = .true.
        do axis = 1, 3
            call leave_out_worst(abs(problem%whiteners(axis)%innovations(problem%acceleration_residual(axis, :))), LIMIT, &
                                 MEDIAN_OF_ONE, problem%acceleration_kept(axis, :), changed)
            kept = kept .and. problem%acceleration_kept(axis, :)
        end do
        if (problem%channel_rows > 0) then
            do axis = 1, 3
                call leave_out_worst(abs(problem%channel_whiteners(axis)%innovations(problem%channel_residual(axis, :))), LIMIT, &
                                     MEDIAN_OF_ONE, kept, changed)
            end do
        end if
        do axis = 1, 3
            problem%acceleration_kept(axis, :) = kept
        end do
        do i = 1, size(normalised)
            normalised(i) = norm2(problem%star_angles(:, i)/problem%noise%of_head(problem%data%stars%head(i)))
        end do
        call leave_out_worst(normalised, LIMIT, MEDIAN_OF_THREE, problem%star_kept, changed)
    end subroutine refresh_and_edit

    !> The covariance of all parameters of an arc, those shared first.
    pure function covariance_of(arc, shared) result(covariance)
        type(arc_t), intent(in) :: arc
        real(dp), intent(in) :: shared(:, :)        !! That of the shared ones
        real(dp) :: covariance(size(shared, 1) + size(arc%own), size(shared, 1) + size(arc%own))

        associate (n => size(shared, 1), gone => arc%eliminated)
            covariance(:n, :n) = shared
            covariance(:n, n + 1:) = -matmul(shared, gone%gain)
            covariance(n + 1:, :n) = transpose(covariance(:n, n + 1:))
            covariance(n + 1:, n + 1:) = gone%covariance_with(shared)
        end associate
    end function covariance_of
end module gracecg_estimation_arc_problem
