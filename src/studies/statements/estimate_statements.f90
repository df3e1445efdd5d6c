!> What CSR-TM-00-01 states of the estimates: weights, accuracy, forces that are no straight line, condition, two places
!> together, and the stars behind them.
module gracecg_studies_estimate_statements
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_quaternion, only: normalised
    use gracecg_base_text, only: integer_text, pick_text, share_text
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_report_problem, only: report_problem_t, prepare_problem
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_simulation_case_models, only: case_star_catalogue
    use gracecg_simulation_dynamics, only: ATTITUDE
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES, SATELLITES
    use gracecg_simulation_star_camera, only: STAR_SELECTIONS
    use gracecg_simulation_star_catalogue, only: star_catalogue_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe_without_noise, error_switches_t
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_studies_examination, only: examination_t, statement_row_t, mm_text, range_text, plain_text, &
        COMBINED_ALGORITHM, FRONT_CASES, BEST_ACCURACY, SMALL_SHARE
    implicit none
    private
    public :: examine_weights, examine_accuracy, examine_curved_force, examine_condition, examine_two_steps, examine_stars

    ! What the verdicts ask for
    real(dp), parameter :: NO_CHANGE = 0.01_dp          !! Of errors, relative: so little is no dependence on a weight
    real(dp), parameter :: DEPENDENCE = 1.1_dp          !! Quotient of errors from which on they depend on a weight
    real(dp), parameter :: REGULAR = 1e8_dp, SINGULAR = 1e12_dp
    !! Condition with unit diagonal: below the first half of the digits is left, above the second hardly any
    real(dp), parameter :: STARS_OF_REPORT = 70, ROUGHLY = 0.25_dp      !! Stars in a field; a relative difference that is rough
    integer, parameter :: STARS_AT_LEAST = 20           !! In every frame

contains

    !> The weights of star camera and accelerometer in ASCFEST.
    subroutine examine_weights(work, error, progress)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        real(dp), parameter :: STAR(5) = [90.0_dp, 1e-4_dp, 1e-8_dp, 1e-11_dp, 1e-16_dp]
        real(dp), parameter :: ACC(3, 3) = reshape([1.0_dp, 1.0_dp, 1.0_dp, 100.0_dp, 1.0_dp, 100.0_dp, &
                                                    0.1_dp, 100.0_dp, 1.0_dp], [3, 3])
        character(8), parameter :: STAR_TEXT(5) = [character(8) :: '90', '1e-4', '1e-8', '1e-11', '1e-16']
        character(12), parameter :: ACC_TEXT(3) = [character(12) :: '1 1 1', '100 1 100', '0.1 100 1']
        type(calibration_t) :: calibration, changed
        real(dp) :: change, range
        integer :: i, n

        call expect_pieces(progress, (size(STAR) + size(ACC_TEXT))*work%runs, 'runs')
        call find_calibration('front-1', calibration, error)
        changed = calibration
        do i = 1, size(STAR)
            changed%options%combined_star_camera_weight = STAR(i)
            call work%add_errors(changed, COMBINED_ALGORITHM, 'star camera '//trim(STAR_TEXT(i)), error, progress)
        end do
        changed = calibration
        do i = 1, size(ACC_TEXT)
            changed%options%accelerometer_weight = ACC(:, i)
            call work%add_errors(changed, COMBINED_ALGORITHM, 'accelerometer '//trim(ACC_TEXT(i)), error, progress)
        end do
        if (allocated(error)) return
        n = size(STAR)
        associate (rows => work%rows)
            change = maxval([(abs(rows(i)%predicted/rows(1)%predicted - 1), i=2, n - 1)])
            range = maxval([(rows(i)%predicted/rows(1)%predicted, i=n + 1, size(rows))])
        end associate
        call work%conclude_halves([change >= NO_CHANGE, range > DEPENDENCE], [character(13) :: 'star camera', 'accelerometer'], &
            'the accelerometer''s weights change the errors by a factor of up to '//trim(plain_text(range, '(f10.1)'))// &
            '; that of the star camera, from '//trim(STAR_TEXT(1))//' down to '//trim(STAR_TEXT(n - 1))//', by '// &
            trim(plain_text(change, '(es9.1)'))//' of them at most.')
    end subroutine examine_weights

    !> The accuracy of section 7.1(3) in the best case of each axis.
    subroutine examine_accuracy(work, error, progress)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        character(:), allocatable :: found
        real(dp) :: best(3)
        integer :: i, axis, place

        call expect_pieces(progress, size(FRONT_CASES)*work%runs, 'runs')
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            call work%add_errors(calibration, COMBINED_ALGORITHM, 'as in the report', error, progress)
            if (allocated(error)) return
        end do
        found = 'by theory'
        do axis = 1, 3
            place = minloc(work%rows%predicted(axis), 1)
            best(axis) = work%rows(place)%predicted(axis)
            found = found//' '//AXES(axis)//' '//trim(mm_text(best(axis)))//' mm in '//trim(work%rows(place)%case_name)// &
                merge('.', ',', axis == 3)
        end do
        call work%conclude(count(best <= BEST_ACCURACY), 3, 'axes', found)
    end subroutine examine_accuracy

    !> What the curvature of drag and light, and the density wave, do to the errors.
    subroutine examine_curved_force(work, error, progress)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        integer :: i

        call expect_pieces(progress, 3*size(REPORT_CASE_NAMES)*work%runs, 'runs')
        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            call work%add_errors(calibration, COMBINED_ALGORITHM, 'curved', error, progress)
            calibration%case%density_wave = density_wave_t()
            calibration%case%density_wave_random = .false.
            call work%add_errors(calibration, COMBINED_ALGORITHM, 'no wave', error, progress)
            call work%add_errors(calibration, COMBINED_ALGORITHM, 'straight line', error, progress, &
                                 error_switches_t(curved_force=.false.))
            if (allocated(error)) return
        end do
        call judge_curved_force(work)
    end subroutine examine_curved_force

    !> Rows in threes: the part of the variance that goes with the curvature, and that which stays without the wave.
    subroutine judge_curved_force(work)
        type(examination_t), intent(inout) :: work

        real(dp), dimension(3, size(work%rows)/3) :: share, smooth
        integer :: i

        do i = 1, size(share, 2)
            associate (curved => work%rows(3*i - 2), no_wave => work%rows(3*i - 1), line => work%rows(3*i))
                share(:, i) = 1 - (line%predicted/curved%predicted)**2
                smooth(:, i) = 1 - (line%predicted/no_wave%predicted)**2
            end associate
        end do
        call work%conclude(count(share < SMALL_SHARE), size(share), 'components', 'the curvature makes '// &
            trim(range_text(share))//' % of their variance, on average '// &
            trim(plain_text(100*sum(share)/size(share), '(f10.0)'))//' %.')
        work%details = 'Without the density wave, whose size and period the report does not give, the curvature '// &
            'changes it by '//trim(range_text(smooth))//' %: of smooth drag and light the statement holds for '// &
            share_text(count(smooth < SMALL_SHARE), size(smooth))//' components.'
    end subroutine judge_curved_force

    !> Why the full state is not singular: the normal matrix of the attitude, full and reduced, and the full one
    !> when an observation counts only across its own quaternion, as its true covariance would have it.
    subroutine examine_condition(work, error)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        character(40), parameter :: SETTINGS(3) = [character(40) :: 'full state (FDE)', 'reduced state (RDE)', &
                                                   'full state weighed across q only']
        type(statement_row_t) :: row
        type(calibration_t) :: calibration
        real(dp) :: full, reduced, across
        integer :: i, k

        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            if (allocated(error)) return
            do k = 1, size(SETTINGS)
                row = statement_row_t(case_name=calibration%case%name, setting=SETTINGS(k))
                call condition_of(calibration, k, row%condition, error)
                if (allocated(error)) return
                work%rows = [work%rows, row]
            end do
        end do
        full = maxval(work%rows(1::3)%condition)
        reduced = maxval(work%rows(2::3)%condition)
        across = minval(work%rows(3::3)%condition)
        call work%conclude(count([full < REGULAR .and. across > SINGULAR]), 1, '', 'condition of the full state to '// &
                           trim(plain_text(full, '(f10.1)'))//', of the reduced one to '//trim(plain_text(reduced, '(f10.1)'))//'.')
        work%details = 'With unit weights every observation determines the length of q as well '// &
            'as its direction; weighed by its own covariance, which has rank three, the full state is '// &
            pick_text(across > SINGULAR, 'singular', 'not singular')//' (condition '//trim(plain_text(across, '(es9.1)'))// &
            ' and more).'
    end subroutine examine_condition

    !> Condition of the normal matrix of kind 1 full, 2 reduced, 3 full with every observation projected across its
    !> quaternion: the ratio of the largest and the least eigenvalue, at the solution.
    subroutine condition_of(calibration, kind, condition, error)
        type(calibration_t), intent(in) :: calibration
        integer, intent(in) :: kind
        real(dp), intent(out) :: condition
        type(error_t), allocatable, intent(out) :: error

        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        type(report_problem_t) :: problem
        type(batch_settings_t) :: settings
        type(batch_solution_t) :: batch
        real(dp), allocatable :: partials(:, :), residuals(:), weights(:), normal(:, :), values(:), vectors(:, :), scale(:)
        real(dp) :: q(4)
        integer :: i, n

        condition = 0
        call new_simulator(calibration%case, simulator, error)
        if (allocated(error)) return
        call observe_without_noise(simulator, density_wave_t(), observations)
        call preprocess(observations, calibration%options, data, error)
        if (allocated(error)) return
        call prepare_problem(observations%knowledge, calibration%options, data, kind == 2, problem)
        call problem%choose(attitude=.true., offset=.false.)
        call process_batch(problem, settings, batch, error)
        if (allocated(error)) return
        n = problem%attitude_parameters
        allocate (partials(n, problem%observations), residuals(problem%observations), weights(problem%observations), &
                  values(n), vectors(n, n))
        call problem%linearise(partials, residuals, weights, error)
        if (allocated(error)) return
        if (kind == 3) then
            do i = 1, size(data%attitude_epoch)
                associate (block => partials(:, 4*i - 3:4*i))
                    q = normalised(matmul(problem%quaternion, block(:4, :)))    ! of the fit, Phi_11 q(t0)
                    block = block - spread(matmul(block, q), 2, 4)*spread(q, 1, n)
                end associate
            end do
        end if
        normal = matmul(partials, transpose(partials))
        scale = [(1/sqrt(normal(i, i)), i=1, n)]
        normal = normal*spread(scale, 1, n)*spread(scale, 2, n)
        call symmetric_eigen(normal, values, vectors, error)
        if (allocated(error)) return
        condition = maxval(values)/max(minval(values), epsilon(1.0_dp)*maxval(values))
    end subroutine condition_of

    !> Two or three places together: the information of their bounds added, for both satellites.
    subroutine examine_two_steps(work, error)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: SETS(3, 7) = reshape([1, 0, 0, 2, 0, 0, 3, 0, 0, 1, 2, 0, 1, 3, 0, 2, 3, 0, 1, 2, 3], [3, 7])
        type(statement_row_t) :: row
        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        real(dp) :: information(3, 3, 3), covariance(3, 3)
        integer :: s, i, k, axis, best, single

        do s = 1, size(SATELLITES)
            do i = 1, 3
                call find_calibration(trim(SATELLITES(s))//'-'//integer_text(i), calibration, error)
                if (.not. allocated(error)) call bound_of_case(calibration%case, calibration%options, bound, error)
                if (allocated(error)) return
                information(:, :, i) = inverse_3x3(bound%covariance/MILLIMETRE**2)
            end do
            do k = 1, size(SETS, 2)
                row = statement_row_t(case_name=trim(SATELLITES(s)), setting='case')
                covariance = 0
                do i = 1, 3
                    if (SETS(i, k) == 0) cycle
                    row%setting = trim(row%setting)//pick_text(i > 1, ' + ', ' ')//integer_text(SETS(i, k))
                    covariance = covariance + information(:, :, SETS(i, k))
                end do
                covariance = inverse_3x3(covariance)
                row%predicted = [(sqrt(covariance(axis, axis))*MILLIMETRE, axis=1, 3)]
                work%rows = [work%rows, row]
            end do
        end do
        ! the front satellite, as in the report
        single = minloc([(maxval(work%rows(k)%predicted), k=1, 3)], 1)
        best = 3 + minloc([(maxval(work%rows(k)%predicted), k=4, 6)], 1)
        associate (two => work%rows(best))
            call work%conclude(count([all(two%predicted <= BEST_ACCURACY)]), 1, '', 'by theory the front satellite''s '// &
                trim(two%setting)//' together have '//trim(mm_text(two%predicted(1)))//', '// &
                trim(mm_text(two%predicted(2)))//' and '//trim(mm_text(two%predicted(3)))//' mm, the best single one, '// &
                trim(work%rows(single)%setting)//', at its worst '// &
                trim(mm_text(maxval(work%rows(single)%predicted)))//' mm.')
        end associate
    end subroutine examine_two_steps

    !> How many stars a camera has before it, and what a choice of those in use gains.
    subroutine examine_stars(work, error, progress)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(statement_row_t) :: row
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(star_catalogue_t) :: catalogue
        real(dp) :: mean
        integer :: i, k, n, range(2)
        integer, allocatable :: seen(:)         ! in a head's field, over an arc

        range = [huge(1), 0]
        mean = 0
        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call case_star_catalogue(calibration%case, catalogue, error)
            if (allocated(error)) return
            call tell(progress, trim(work%name)//', '//trim(calibration%case%name))
            mean = calibration%case%satellite%star_camera%mean_stars_in_field(catalogue)
            do k = 1, size(STAR_SELECTIONS)
                calibration%case%satellite%star_camera%selection = STAR_SELECTIONS(k)
                call new_simulator(calibration%case, simulator, error)
                if (allocated(error)) return
                associate (camera => calibration%case%satellite%star_camera, head => calibration%case%operator%head, &
                           arc => simulator%arc)
                    seen = [(camera%stars_in_field(catalogue, arc%state(ATTITUDE, n), head), n=1, arc%steps, &
                             nint(camera%sampling_interval/arc%interval))]
                    row = statement_row_t(case_name=calibration%case%name, setting=trim(STAR_SELECTIONS(k))//' '// &
                                          integer_text(camera%star_count)//' stars', stars=real(sum(seen), dp)/size(seen), &
                                          camera_sigma=simulator%star_camera_sigma)
                end associate
                work%rows = [work%rows, row]
            end do
            range = [min(range(1), minval(seen)), max(range(2), maxval(seen))]
        end do
        call judge_stars(mean, range, work)
    end subroutine examine_stars

    !> The number and the choice are two halves of the statement. Rows in twos: the first stars, the best ones.
    subroutine judge_stars(mean, range, work)
        real(dp), intent(in) :: mean            !! Stars in a field, over all attitudes
        integer, intent(in) :: range(2)         !! In the cases, fewest and most
        type(examination_t), intent(inout) :: work

        real(dp) :: first(3, size(work%rows)/2), best(3, size(work%rows)/2)     ! Sigmas of the camera
        logical :: so_many
        integer :: i

        do i = 1, size(first, 2)
            first(:, i) = work%rows(2*i - 1)%camera_sigma
            best(:, i) = work%rows(2*i)%camera_sigma
        end do
        so_many = abs(mean/STARS_OF_REPORT - 1) <= ROUGHLY .and. range(1) >= STARS_AT_LEAST
        call work%conclude_halves([so_many, all(best(3, :) < first(3, :))], [character(6) :: 'number', 'choice'], 'a field has '// &
            trim(plain_text(mean, '(f10.1)'))//' stars on average of all attitudes, '//integer_text(range(1))//' to '// &
            integer_text(range(2))//' in the cases; with the best '//integer_text(STARS_AT_LEAST)// &
            ' sigma about the boresight is '//trim(range_text(best(3:, :)/first(3:, :)))//' % of that with the first.')
        work%details = 'Across the boresight it is '//trim(plain_text(100*sum(best(:2, :))/sum(first(:2, :)), '(f6.0)'))// &
            ' % on average. What the star camera''s noise does to the offset: Figure 6.5.'
    end subroutine judge_stars
end module gracecg_studies_estimate_statements
