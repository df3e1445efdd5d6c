!> An arc in a fit of several (gracecg_estimation_arcs): its samples, one of the accelerometer at every epoch, its whitened problem,
!> and what it says of the parameters that all arcs share.
module gracecg_estimation_arc_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_autoregression, only: autoregression_t, autocovariances_t, predictors_of
    use gracecg_base_coloured_noise, only: noise_spectrum_t
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: grouped_normal_equations
    use gracecg_base_statistics, only: median_of
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters, only: ALL_RODS_DELAY, ROD_DELAYS
    use gracecg_estimation_information, only: information_t, eliminated_t, no_information
    use gracecg_estimation_iteration, only: rms_of
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_noise_whitening, only: autoregressive_whitener
    use gracecg_estimation_outlier_editing, only: leave_out_worst, MEDIAN_OF_ONE, MEDIAN_OF_THREE
    use gracecg_estimation_model_state, only: initial_state
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, fit_point_t, point_of, problem_at
    implicit none
    private
    public :: arc_t, arc_residuals_t, prepare_arc, open_arc, first_noise, find_disturbed, reduce_arc, refresh_and_edit, &
        covariance_of, LEAST_ANGLE

    real(dp), parameter :: LIMIT = 6                !! Of editing, standard deviations
    real(dp), parameter :: FIRST_LEVEL = 2e-9_dp, FIRST_ANGULAR = 1e-7_dp, FIRST_ANGLE = 1e-6_dp
    !! Standard deviations to begin with, m/s^2, rad/s^2, rad
    real(dp), parameter :: LEAST_ANGLE = 1e-8_dp    !! Standard deviation of a star camera, rad: samples without noise weigh
    !! no more

    !> What the fit leaves of an arc's samples of the accelerometer, every epoch.
    type :: arc_residuals_t
        real(dp), allocatable :: linear(:, :)       !! (3, epochs), m/s^2
        real(dp), allocatable :: angular(:, :)      !! (3, epochs), rad/s^2; of size 0 without angular channels
        logical, allocatable :: kept(:)             !! False: missing, or left out
    end type arc_residuals_t

    !> An arc in the fit: its samples and where it has got to, not the partials, which are made anew where they are used: they
    !> would take a megabyte an arc.
    type :: arc_t
        type(fitting_data_t) :: data                !! With a sample of the accelerometer at every epoch
        integer, allocatable :: own(:)              !! Its own parameters, places among all
        logical :: held = .false.                   !! The moments of the rods are
        type(fit_point_t) :: point                  !! With the parameters shared and its own
        real(dp) :: excess(6) = 1                   !! Of the noise of the accelerometer's axes and channels over that of all arcs
        type(information_t) :: information          !! About corrections of the shared parameters
        type(eliminated_t) :: eliminated            !! Corrections of its own
        type(arc_residuals_t) :: residuals          !! At the point
        real(dp) :: innovations(6) = 0              !! RMS, of axes and channels, standard deviations
        real(dp) :: head_squares(3, 2) = 0          !! Sums over the samples of each star-camera head, by its axes, rad^2
        integer :: head_samples(2) = 0              !! That are kept
    end type arc_t

contains

    !> The samples of an arc; where it had been there before, it stays where it was.
    subroutine prepare_arc(set, options, shared, own, arc, error)
        type(observation_set_t), intent(in) :: set
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: shared(:), own(:)    !! Places of the parameters of all arcs, and of this one's own
        type(arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        logical, allocatable :: there(:)
        integer :: axis, k

        call preprocess(set, options, arc%data, error)
        if (allocated(error)) return
        call take_all_epochs(arc%data, there)
        if (allocated(arc%own)) return
        arc%own = own
        arc%held = set%knowledge%rods%measured%held
        arc%point%estimated = [shared, own]
        arc%point%state = initial_state(arc%data, options)
        allocate (arc%point%stars_left_out(0))
        arc%point%accelerations_left_out = pack([(k, k=1, 3*size(there))], .not. [(there(1 + (k - 1)/3), k=1, 3*size(there))])
        associate (noise => arc%point%noise)
            noise%star_camera_sigma = FIRST_ANGLE
            noise%second_head_sigma = [1.0_dp, FIRST_ANGLE, 1.0_dp]
            do axis = 1, 3
                noise%accelerometer(axis) = noise_spectrum_t(2*arc%data%interval*FIRST_LEVEL**2, 0.0_dp, &
                                                             set%knowledge%accelerometer_noise(axis)%sides)
            end do
        end associate
    end subroutine prepare_arc

    !> The problem of an arc where it is, for the noise of all arcs; with other parameters, if they are given.
    subroutine open_arc(arc, set, options, linear, angular, problem, parameters)
        type(arc_t), intent(in) :: arc
        type(observation_set_t), intent(in) :: set
        type(estimation_options_t), intent(in) :: options
        type(autoregression_t), intent(in) :: linear(3), angular(3)
        type(whitened_problem_t), intent(out) :: problem
        integer, intent(in), optional :: parameters(:)      !! Shared ones; absent: those of the fit

        type(fitting_data_t) :: data
        type(fit_point_t) :: point

        data = arc%data
        point = arc%point
        if (present(parameters)) point%estimated = [parameters, arc%own]
        call problem_at(set%knowledge, options, data, point, problem)
        call problem%forget_prior(size(point%estimated) - size(arc%own))
        call take_noise(arc%excess, linear, angular, problem)
    end subroutine open_arc

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

    !> White noise to begin with: of the axes, or of the channels.
    pure function first_noise(of_channels) result(models)
        logical, intent(in) :: of_channels          !! Else of the linear axes
        type(autoregression_t) :: models(3)

        type(autocovariances_t) :: sums

        call sums%begin(1)
        sums%sums(0) = merge(FIRST_ANGULAR, FIRST_LEVEL, of_channels)**2
        models = predictors_of(sums, 1.0_dp)
    end function first_noise

    !> Whiteners of an arc for the noise of the axes.
    subroutine take_noise(excess, linear, angular, problem)
        real(dp), intent(in) :: excess(6)           !! Of the arc
        type(autoregression_t), intent(in) :: linear(3), angular(3)     !! That of all arcs
        type(whitened_problem_t), intent(inout) :: problem

        type(autoregression_t) :: model         ! of the same spectrum, so many times larger
        integer :: axis

        do axis = 1, 3
            associate (kept => problem%acceleration_kept(axis, :))
                model = linear(axis)
                model%deviation = excess(axis)*model%deviation
                call autoregressive_whitener(model, kept, problem%whiteners(axis))
                if (problem%channel_rows == 0) cycle
                model = angular(axis)
                model%deviation = excess(3 + axis)*model%deviation
                call autoregressive_whitener(model, kept, problem%channel_whiteners(axis))
            end associate
        end do
    end subroutine take_noise

    !> Which arcs are disturbed: their noise is so much larger than that of most that they would take weight from the others. They
    !> count by their own.
    pure subroutine find_disturbed(arcs)
        type(arc_t), intent(inout) :: arcs(:)

        integer, parameter :: FEWEST = 20               ! Arcs: of fewer most may be disturbed
        real(dp), parameter :: MUCH = 1.5_dp, SIGMAS = 6    ! Chosen: times the noise of most, and its scatter
        real(dp) :: noise(6, size(arcs))
        integer :: i, axis

        if (size(arcs) < FEWEST) return
        do i = 1, size(arcs)
            noise(:, i) = arcs(i)%excess*arcs(i)%innovations
        end do
        do axis = 1, 6
            noise(axis, :) = noise(axis, :)/max(median_of(noise(axis, :)), tiny(1.0_dp))
        end do
        do i = 1, size(arcs)
            associate (scatter => 1/sqrt(2.0_dp*max(1, count(arcs(i)%residuals%kept))))
                arcs(i)%excess = merge(noise(:, i), 1.0_dp, noise(:, i) > max(MUCH, 1 + SIGMAS*scatter))
            end associate
        end do
    end subroutine find_disturbed

    !> The normal equations of an arc without its own parameters. Samples of the accelerometer between the steps of held moments
    !> are the same with another delay of the rods: that is told by the attitude.
    subroutine reduce_arc(arc, problem, n, error, channels)
        type(arc_t), intent(inout) :: arc
        type(whitened_problem_t), intent(inout) :: problem      !! Of it
        integer, intent(in) :: n                    !! Number of shared parameters
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: channels   !! The angular channels count; absent: they do

        real(dp), allocatable :: partials(:, :), residuals(:), weights(:)
        integer :: all, k

        all = n + size(arc%own)
        allocate (partials(all, problem%observations), residuals(problem%observations), weights(problem%observations))
        call problem%linearise(partials, residuals, weights, error)
        if (allocated(error)) return
        if (present(channels)) then
            if (.not. channels) partials(:, problem%star_rows + problem%acceleration_rows + 1:problem%sample_rows()) = 0
        end if
        if (arc%held) then
            do k = 1, all
                if (any(problem%model%estimated(k) == [ALL_RODS_DELAY, ROD_DELAYS])) &
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
    end subroutine reduce_arc

    !> Residuals at the state, and what does not belong to the fit left out.
    subroutine refresh_and_edit(arc, problem, changed)
        type(arc_t), intent(inout) :: arc
        type(whitened_problem_t), intent(inout) :: problem      !! Of it
        logical, intent(inout) :: changed           !! Set if another sample is left out

        real(dp) :: residuals(problem%observations), normalised(size(problem%star_kept))
        real(dp) :: left(6, size(problem%acceleration_kept, 2))     ! innovations
        logical :: kept(size(problem%acceleration_kept, 2))
        integer :: axis, head, i

        call problem%compare(residuals)
        kept = .true.
        left = 0
        do axis = 1, 3
            left(axis, :) = problem%whiteners(axis)%innovations(problem%acceleration_residual(axis, :))
            call leave_out_worst(abs(left(axis, :)), LIMIT, MEDIAN_OF_ONE, problem%acceleration_kept(axis, :), changed)
            kept = kept .and. problem%acceleration_kept(axis, :)
        end do
        do axis = 1, merge(3, 0, problem%channel_rows > 0)
            left(3 + axis, :) = problem%channel_whiteners(axis)%innovations(problem%channel_residual(axis, :))
            call leave_out_worst(abs(left(3 + axis, :)), LIMIT, MEDIAN_OF_ONE, kept, changed)
        end do
        do axis = 1, 3
            problem%acceleration_kept(axis, :) = kept
        end do
        do i = 1, size(normalised)
            normalised(i) = norm2(problem%star_angles(:, i)/problem%noise%of_head(problem%data%stars%head(i)))
        end do
        call leave_out_worst(normalised, LIMIT, MEDIAN_OF_THREE, problem%star_kept, changed)
        arc%point = point_of(problem)
        arc%innovations = [(rms_of(pack(left(i, :), kept)), i=1, size(left, 1))]
        arc%residuals = arc_residuals_t(problem%acceleration_residual, problem%channel_residual, kept)
        do head = 1, 2
            associate (counted => problem%star_kept .and. problem%data%stars%head == head)
                arc%head_samples(head) = count(counted)
                arc%head_squares(:, head) = [(sum(problem%star_angles(axis, :)**2, mask=counted), axis=1, 3)]
            end associate
        end do
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
