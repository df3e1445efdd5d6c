!> What a calibration's page shows, as members of the JSON of `gracecg estimate`: the samples, the manoeuvre, what the fit
!> tells of itself, the verdict, and the series behind the figures. docs/formats.md names the members.
module gracecg_cli_calibration_json
    use gracecg_environment_time, only: time_tag
    use gracecg_files_json, only: json_writer_t
    use gracecg_files_file, only: text_file_t, read_text_file, file_exists
    use gracecg_spacecraft_moment_series, only: has_moments
    use gracecg_spacecraft_torque_rods, only: dipole_moment
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t
    use gracecg_cli_plan_results, only: rods_table
    use gracecg_estimation_action, only: action_t, ACTIONS, WANTED_ACCURACY
    use gracecg_estimation_offset_movement, only: movement_t
    use gracecg_estimation_verdict, only: verdict_t, GRADE_BAD
    use gracecg_cli_results, only: put_columns
    use gracecg_cli_work
    implicit none
    private
    public :: put_action, put_movement, put_input, put_observed, put_fit, put_verdict, put_fit_tables

    character(8), parameter :: GRADES(GRADE_BAD) = [character(8) :: 'good', 'doubtful', 'bad']

contains

    !> What to do, first of all.
    subroutine put_action(action, json)
        type(action_t), intent(in) :: action
        class(json_writer_t), intent(inout) :: json

        call json%begin('action')
        call json%member('kind', trim(ACTIONS(action%kind)))
        call json%member('text', action%text)
        call json%member('trim_axes', pack(AXES, action%trimmed))
        call json%member('calibrate_again_axes', pack(AXES, action%again))
        if (any(action%sigma > 0)) call json%member('sigma_mm', action%sigma/MILLIMETRE)
        call json%end()
    end subroutine put_action

    !> How the offset moves.
    subroutine put_movement(movement, json)
        type(movement_t), intent(in) :: movement
        class(json_writer_t), intent(inout) :: json

        call json%begin('movement')
        call json%member('kind', trim(movement%kind))
        if (movement%kind /= 'none') then
            call json%member('from_utc', utc_text(movement%from))
            call json%member('to_utc', utc_text(movement%to))
            call json%member('change_mm', movement%change/MILLIMETRE)
            call json%member('sigma_mm', movement%sigma/MILLIMETRE)
            call json%member('probability', movement%probability)
        end if
        call json%end()
    end subroutine put_movement

    !> The text of a file that the estimate was made with; nothing where it cannot be read.
    subroutine put_input(path, json)
        character(*), intent(in) :: path                !! Of the file; nothing is put where there is none
        class(json_writer_t), intent(inout) :: json     !! In an array

        type(text_file_t) :: file
        type(error_t), allocatable :: error

        if (.not. file_exists(path)) return
        call read_text_file(path, file, error)
        if (allocated(error)) return
        call json%begin()
        call json%member('path', path)
        call json%member('text', file%text)
        call json%end()
    end subroutine put_input

    !> Satellite, samples of each instrument, and the manoeuvre.
    subroutine put_observed(observations, json)
        type(observation_set_t), intent(in) :: observations
        class(json_writer_t), intent(inout) :: json

        type(data_table_t) :: rods
        integer :: head

        associate (o => observations, knowledge => observations%knowledge)
            call json%member('duration_s', knowledge%duration)
            call json%begin('satellite')
            call json%member('mass_kg', knowledge%mass)
            call json%member('inertia_kg_m2', knowledge%inertia)
            call json%end()
            call json%begin_array('samples')
            call put_samples('accelerometer', knowledge%accelerometer_interval, o%accelerometer_time, .true.)
            do head = 1, HEADS
                call put_samples('star camera '//integer_text(head), knowledge%star_camera_interval, &
                                 pack(o%star_camera_time, o%star_camera_head == head), head == knowledge%camera)
            end do
            call put_samples('magnetometer', knowledge%magnetometer_interval, o%magnetometer_time, .true.)
            if (has_orbit(o)) call put_samples('orbit', 0.0_dp, o%orbit_time, .true.)
            call json%end()
            call json%begin('manoeuvre')
            if (knowledge%rods%direct) call json%member('torquers', .true.)
            rods = rods_table(knowledge%rods, knowledge%epoch)
            call rods%to_json(json, 'rods', units=.false.)
            if (has_moments(knowledge%rods%measured)) call json%member('measured_moments', size(knowledge%rods%measured%time))
            call json%end()
        end associate

    contains

        subroutine put_samples(name, interval, times, used)
            character(*), intent(in) :: name
            real(dp), intent(in) :: interval    !! s; 0: free
            real(dp), intent(in) :: times(:)    !! s
            logical, intent(in) :: used         !! By the estimators

            integer :: n

            n = size(times)
            call json%begin(on_one_line=.true.)
            call json%member('instrument', name)
            call json%member('used', used)
            call json%member('samples', n)
            if (interval > 0) then
                call json%member('interval_s', interval)
                call json%member('full', nint(observations%knowledge%duration/interval))
            end if
            if (n > 1) call json%member('longest_step_s', maxval(times(2:) - times(:n - 1)))
            if (n > 0) then
                call json%member('first_s', times(1))
                call json%member('last_s', times(n))
                call json%member('first_utc', utc_text(utc_plus(observations%knowledge%epoch, times(1))))
                call json%member('last_utc', utc_text(utc_plus(observations%knowledge%epoch, times(n))))
            end if
            call json%end()
        end subroutine put_samples
    end subroutine put_observed

    !> What the fit tells of itself.
    subroutine put_fit(knowledge, record, diagnostics, json)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        class(json_writer_t), intent(inout) :: json

        integer :: axis, k

        associate (d => diagnostics)
            call json%begin('fit')
            call json%member('sigma_known', d%sigma_known)
            call json%begin('ellipsoid')
            call json%member('semi_axes_m', d%ellipsoid%semi_axis)
            call json%member('directions', transpose(d%ellipsoid%direction))
            call json%end()
            call json%member('correlation', d%correlation)
            call json%member('information_share', d%information_share)
            if (d%bound_known) call json%member('sigma_at_best_m', d%bound)
            call json%member('source_share', d%source_share)
            call json%begin_array('parameter_correlation')
            do k = 1, size(d%parameter_correlation, 2)
                call json%begin(on_one_line=.true.)
                call json%member('name', trim(record%names(k + 3)))
                call json%member('d', d%parameter_correlation(:, k))
                call json%end()
            end do
            call json%end()
            call json%begin_array('residuals')
            do axis = 1, 3
                associate (r => d%residuals(axis))
                    call json%begin(on_one_line=.true.)
                    call json%member('axis', AXES(axis))
                    call json%member('rms_m_s2', r%rms)
                    if (r%noise_known) then
                        call json%member('expected_rms_m_s2', r%expected_rms)
                        call json%member('whitened_rms', r%ratio)
                        call json%member('whitened_rms_sigma', r%ratio_sigma)
                        call json%member('lag_1_correlation', r%autocorrelation(1))
                        call json%member('probability_white', r%probability)
                    end if
                    call json%member('largest_m_s2', r%worst)
                    call json%member('largest_at_s', r%worst_time)
                    call json%member('largest_at_utc', utc_text(utc_plus(knowledge%epoch, r%worst_time)))
                    call json%end()
                end associate
            end do
            call json%end()
            call json%end()
        end associate
    end subroutine put_fit

    !> Grade and findings.
    subroutine put_verdict(verdict, json)
        type(verdict_t), intent(in) :: verdict
        class(json_writer_t), intent(inout) :: json

        integer :: i

        call json%begin('verdict')
        call json%member('grade', trim(GRADES(verdict%grade)))
        call json%member('wanted_accuracy_m', WANTED_ACCURACY)
        call json%begin_array('findings')
        do i = 1, size(verdict%findings)
            call json%begin()
            call json%member('grade', trim(GRADES(verdict%findings(i)%grade)))
            call json%member('subject', verdict%findings(i)%subject)
            call json%member('text', verdict%findings(i)%text)
            call json%end()
        end do
        call json%end()
        call json%end()
    end subroutine put_verdict

    !> The series behind the figures, by columns; a page's folder has each as CSV. Frequency 0 is left out of the spectra,
    !> which are one-sided amplitudes.
    subroutine put_fit_tables(knowledge, record, diagnostics, json)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        class(json_writer_t), intent(inout) :: json

        real(dp) :: time(size(record%epoch)), moment(3, size(record%epoch))
        integer :: i

        time = [(time_tag(record%epoch(i), record%interval), i=1, size(time))]
        do i = 1, size(time)
            moment(:, i) = dipole_moment(knowledge%rods, time(i))
        end do
        call json%begin('tables')
        call json%begin('manoeuvre')
        call json%member('time_s', time)
        if (knowledge%rods%direct) then
            call put_columns(json, 't', '_n_m', moment)
        else
            call put_columns(json, 'm', '_a_m2', moment)
        end if
        call put_columns(json, 'wd', '_rad_s2', record%angular_acceleration)
        call json%end()
        call json%begin('residuals')
        call json%member('time_s', time)
        call put_columns(json, '', '_m_s2', record%residual)
        call json%end()
        associate (d => diagnostics)
            call json%begin('spectrum')
            call json%member('frequency_hz', d%frequency(2:))
            call put_columns(json, '', '_m_s2_sqrt_hz', sqrt(2*d%density(:, 2:)))
            call put_columns(json, 'expected_', '_m_s2_sqrt_hz', sqrt(2*d%expected_density(:, 2:)))
            call json%end()
            call json%begin('spectrum_bands')
            call json%member('frequency_hz', d%band_frequency)
            call put_columns(json, '', '_m_s2_sqrt_hz', sqrt(2*d%band_density))
            call json%end()
        end associate
        call json%end()
    end subroutine put_fit_tables
end module gracecg_cli_calibration_json
