!> gracecg estimate: the CG offset from an observation set.
module gracecg_cli_estimate
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, integer_text
    use gracecg_spacecraft_torque_rods, only: check_rods_fire
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_observation_files, only: read_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_estimation_options, only: estimation_options_t, read_options, OF_SETUP
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_belief, only: BELIEFS
    use gracecg_estimation_belief_report, only: belief_report_t, NOISE_SUBJECTS
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_files_file, only: check_writable
    use gracecg_cli_calibration_page, only: write_calibration_page, page_folder
    use gracecg_estimation_estimators, only: estimate_offset, ESTIMATOR_NAMES
    use gracecg_cli_running_file, only: write_running_estimate
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t, number_fields
    implicit none
    private
    public :: declare_estimate, run_estimate

    character(*), parameter :: COLUMNS = &
        'algorithm,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,'// &
        'iterations,converged,condition,residual_rms_x,residual_rms_y,residual_rms_z'
    character(4), parameter :: FORMATS(2) = ['text', 'csv ']

contains

    !> Arguments and help of `gracecg estimate`.
    subroutine declare_estimate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('estimate', 'DIR', 1, 1, &
                                'Estimates the offset of the centre of gravity, from the '// &
                                'centre of mass to the proof-mass centre in body axes, from '// &
                                'the observation set in DIR. The exit status is 1 when the '// &
                                'estimate does not converge.', &
                                'gracecg simulate front-1 --out run1'//new_line('a')// &
                                'gracecg estimate run1 --algorithm assest-fde --report run1.html')
        call arguments%add_option('--algorithm', 'NAME', algorithm_help(), required=.true.)
        call arguments%add_option('--options', 'FILE', 'namelist file that says how to estimate: weights, first '// &
                                  'guesses, what else to estimate (default: what the algorithm needs no telling)')
        call arguments%add_option('--format', 'FORMAT', 'text (default) or csv')
        call arguments%add_option('--report', 'FILE.html', 'writes a page on this calibration: errors, what '// &
                                  'they come from, residuals, verdict; its numbers and gnuplot scripts go '// &
                                  'into the folder FILE_files')
        call arguments%add_option('--running', 'FILE', 'CSV of the estimate as it grows with the samples; '// &
                                  'sequential alone has one')
    end subroutine declare_estimate

    function algorithm_help() result(text)
        character(:), allocatable :: text

        integer :: i

        text = 'one of:'
        do i = 1, size(ESTIMATOR_NAMES)
            text = text//' '//trim(ESTIMATOR_NAMES(i))
        end do
    end function algorithm_help

    !> The work of `gracecg estimate`.
    subroutine run_estimate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        type(fit_record_t) :: record
        character(:), allocatable :: algorithm, output_format, page, running_file, options_file

        call arguments%get('--algorithm', algorithm, misuse, choices=ESTIMATOR_NAMES)
        call arguments%get('--format', output_format, misuse, default='text', choices=FORMATS)
        call arguments%get('--report', page, misuse, default='')
        call arguments%get('--running', running_file, misuse, default='')
        call arguments%get('--options', options_file, misuse, default='')
        call refuse_if(running_file /= '' .and. algorithm /= 'sequential', '--running: '//algorithm// &
                       ' estimates from all samples at once and has no running estimate; use --algorithm '// &
                       'sequential', misuse)
        if (allocated(misuse)) return

        call check_writable(page, error)
        if (.not. allocated(error)) call check_writable(running_file, error)
        if (.not. allocated(error)) call read_observations(arguments%positional(1), observations, error)
        if (.not. allocated(error)) &
            call check_rods_fire(observations%knowledge%rods, observations%knowledge%duration, error)
        if (.not. allocated(error)) call take_options(arguments%positional(1), options_file, options, console, error)
        if (allocated(error)) return
        if (page == '') then
            call estimate_offset(algorithm, observations, options, solution, error)
        else
            call estimate_offset(algorithm, observations, options, solution, error, record=record)
        end if
        if (.not. allocated(error) .and. running_file /= '') &
            call write_running_estimate(running_file, solution%running, error)
        if (allocated(error)) return
        call warn(observations%knowledge, solution, console)
        if (output_format == 'csv') then
            call print_csv(solution, console, error)
        else
            call print_text(observations%knowledge, solution, console)
        end if
        if (.not. allocated(error) .and. page /= '') then
            call write_calibration_page(page, arguments%positional(1), options_file, observations, solution, record, &
                                        console, error)
            if (.not. allocated(error) .and. output_format == 'text') &
                call console%line('written: '//page//'; its numbers and scripts: '//page_folder(page))
        end if
        if (allocated(error) .or. solution%converged) return
        call fail(error, algorithm//' did not converge in '//integer_text(solution%iterations)// &
                  ' iterations: the offset is not to be relied upon; check the star-camera '// &
                  'samples, or give guess_quaternion and guess_angular_velocity with --options')
    end subroutine run_estimate

    !> The options of --options; without it those that need no telling, or those in a setup.nml of version 0.1.
    subroutine take_options(folder, options_file, options, console, error)
        character(*), intent(in) :: folder, options_file
        type(estimation_options_t), intent(out) :: options
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(estimation_options_t) :: former
        type(string_t), allocatable :: warning

        call read_options(folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), former, error, OF_SETUP, warning)
        if (allocated(error)) return
        if (allocated(warning)) call console%message('warning: '//warning%text)
        options = former
        if (options_file /= '') call read_options(options_file, options, error)
    end subroutine take_options

    !> What the estimator had to bridge, and what the formal errors leave out.
    subroutine warn(knowledge, solution, console)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        integer :: i

        do i = 1, size(solution%warnings)
            call console%message('warning: '//solution%warnings(i)%text)
        end do
        if (all(solution%noise_level > 0)) return       ! what is not given has been estimated
        if (.not. all(knowledge%accelerometer_noise%level > 0)) &
            call console%message('warning: the setup gives no noise_level of the accelerometer '// &
                                 'for some axis: the sigmas leave it out')
        if (.not. all(knowledge%star_camera_sigma > 0)) &
            call console%message('warning: the setup gives no noise_about_axes of the star '// &
                                 'camera for some axis: the sigmas leave it out')
    end subroutine warn

    subroutine print_csv(solution, console, error)
        type(solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(string_t) :: fields(13)

        fields(1)%text = solution%algorithm
        fields(2:4) = number_fields(solution%offset/MILLIMETRE)
        fields(5:7) = number_fields(sigmas(solution)/MILLIMETRE)
        fields(8)%text = integer_text(solution%iterations)
        fields(9)%text = merge('T', 'F', solution%converged)
        fields(10:10) = number_fields([solution%condition])
        fields(11:13) = number_fields(solution%residual_rms)
        call console%row(COLUMNS, fields, error)
    end subroutine print_csv

    pure function sigmas(solution) result(sigma)
        type(solution_t), intent(in) :: solution
        real(dp) :: sigma(3)        !! m

        integer :: i

        sigma = [(sqrt(solution%covariance(i, i)), i=1, 3)]
    end function sigmas

    !> A number with five decimals, or with an exponent where they do not fit into the width.
    pure function fitting_text(value, width) result(text)
        real(dp), intent(in) :: value
        integer, intent(in) :: width
        character(width) :: text

        write (text, '(f'//integer_text(width)//'.5)') value
        if (index(text, '*') > 0) write (text, '(es'//integer_text(width)//'.2)') value
    end function fitting_text

    subroutine print_text(knowledge, solution, console)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        character(120) :: line
        real(dp) :: sigma(3)
        integer :: i

        sigma = sigmas(solution)
        call console%line(trim(knowledge%name)//', '//solution%algorithm// &
                          ': CG offset, from centre of mass to proof-mass centre, body axes')
        do i = 1, 3
            call console%line('  '//AXES(i)//fitting_text(solution%offset(i)/MILLIMETRE, 12)// &
                              ' mm   sigma'//fitting_text(sigma(i)/MILLIMETRE, 10)//' mm')
        end do
        call console%line('iterations        '//integer_text(solution%iterations)// &
                          trim(merge(' (converged)    ', ' (not converged)', solution%converged)))
        write (line, '("condition number  ", es9.2)') solution%condition
        call console%line(trim(line))
        write (line, '("residual RMS      ", 2(es10.3, ", "), es10.3)') solution%residual_rms
        call console%line(trim(line)//' m/s^2 (accelerometer x, y, z)')
        if (solution%variance_factor > 0) call print_details(solution, console)
        if (allocated(solution%beliefs)) call print_beliefs(solution%beliefs, console)
    end subroutine print_text

    !> What `optimal` says beside the offset.
    subroutine print_details(solution, console)
        type(solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        character(120) :: line
        integer :: i

        write (line, '("variance factor   ", f9.4, a)') solution%variance_factor, &
            ' (1 when model and noise are right)'
        call console%line(trim(line))
        write (line, '("noise level       ", 2(es10.3, ", "), es10.3, a)') solution%noise_level, ' m^2 s^-4/Hz'
        call console%line(trim(line))
        write (line, '("noise corner      ", 2(es10.3, ", "), es10.3, a)') solution%noise_corner, ' Hz'
        call console%line(trim(line))
        write (line, '("star camera sigma ", 2(es10.3, ", "), es10.3, a)') solution%star_camera_sigma, &
            ' rad (camera x, y, boresight)'
        call console%line(trim(line))
        do i = 1, size(solution%parameters)
            associate (p => solution%parameters(i))
                write (line, '(a18, es10.3, "   sigma ", es9.2, 1x, a)') p%name//'      ', p%value, p%sigma, &
                    trim(unit_of(p%name))
            end associate
            call console%line(trim(line))
        end do
    end subroutine print_details

    subroutine print_beliefs(report, console)
        type(belief_report_t), intent(in) :: report
        type(console_t), intent(inout) :: console

        character(160) :: line
        integer :: i

        do i = 1, size(report%values)
            associate (t => report%values(i), b => BELIEFS(report%values(i)%belief))
                write (line, '(a36, i2, f10.2, es11.3, es10.2, es10.2, 3es10.2, 1x, a)') b%subject, t%state, t%score, &
                    t%value/b%size, t%sigma/b%size, t%detectable/b%size, min(abs(t%effect)/MILLIMETRE, 1e9_dp), b%unit
                call console%line(trim(line))
            end associate
        end do
        do i = 1, size(report%noises)
            write (line, '(a36, i2, f10.2, f10.3)') NOISE_SUBJECTS(report%noises(i)%subject), report%noises(i)%state, &
                report%noises(i)%score, report%noises(i)%factor
            call console%line(trim(line))
        end do
    end subroutine print_beliefs

    !> The unit of a parameter, by its name.
    pure function unit_of(name) result(unit)
        character(*), intent(in) :: name
        character(5) :: unit

        unit = ''
        if (index(name, 'torque') == 1) unit = 'N m'
        if (name == 'drag_curve' .or. index(name, 'wave') == 1) unit = 'm/s^2'
        if (name == 'wave_freq') unit = 'Hz'
        if (index(name, 'field') == 1) unit = 'T'
    end function unit_of
end module gracecg_cli_estimate
